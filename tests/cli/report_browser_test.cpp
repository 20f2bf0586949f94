// The report of `coppice evaluate --html` in headless Chromium. A probe is appended to a copy of the page; it waits until the page is
// drawn, uses its controls and writes what it finds as JSON into the document, which Chromium prints. Anything on the console fails.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.h"

namespace {

namespace fs = std::filesystem;
using coppice::test::ProcessResult;
using coppice::test::program_on_path;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

constexpr const char* kProbe = R"probe(
<pre id="probe"></pre>
<script>
(async () => {
  const pause = () => new Promise(resolve => setTimeout(resolve, 20));
  while (document.documentElement.dataset.report !== 'ready') await pause();
  await pause();
  const inked = (canvas, counts = alpha => alpha > 0) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {willReadFrequently: true});
    copy.drawImage(canvas, 0, 0);
    const pixels = copy.getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) count += counts(pixels[i + 3], pixels[i]) ? 1 : 0;
    return count;
  };
  const canvases = [...document.querySelectorAll('canvas')];
  const background = () => getComputedStyle(document.body).backgroundColor;
  const found = {
    title: document.title,
    plant: document.getElementById('plant').textContent,
    width: innerWidth,
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    inked: canvases.map(canvas => inked(canvas)),
    background: background(),
    pictures: document.querySelectorAll('.picture').length,
    rows: document.querySelectorAll('#table tbody tr').length,
    best: document.querySelectorAll('#table td.best').length,
    sentences: document.querySelectorAll('#headline li').length,
    bold: document.querySelectorAll('b').length,
  };
  document.querySelector('#legend button').click();
  document.querySelector('input[value=levels]').click();
  document.querySelector('input[value=difference]').click();
  document.querySelector('input[name=measure][value=coverage]').click();
  await drawGallery();
  found.inked_after = canvases.map(canvas => inked(canvas));
  found.pressed = document.querySelector('#legend button').getAttribute('aria-pressed');
  found.pictures_after = document.querySelectorAll('.picture.difference').length;
  found.caption = document.querySelector('#table caption').textContent;
  const source = await shrunk(data.source_picture, 64), other = await shrunk(data.methods[0].levels[0].picture, 64);
  found.shrunk = source.width;
  found.same = inked(difference(source, source), (alpha, red) => red < 255);
  found.different = inked(difference(source, other), (alpha, red) => red < 255);
  document.querySelector('#theme').click();
  found.light = background();
  document.querySelector('#theme').click();
  found.dark = background();
  document.getElementById('probe').textContent = JSON.stringify(found);
})();
</script>
)probe";

enum class Scheme { dark, light };  // Blink's numbers

/// Chromium's clock jumps from timer to timer, while pictures are decoded in real time: this is 10,000 rounds of the probe's waiting. On a
/// busy machine they can be too few, so a page that was not drawn in time is given more, kAttempts times.
constexpr int kVirtualMilliseconds = 200'000;
constexpr int kAttempts = 4;

struct Visit {
  std::string document;  ///< the DOM at the end
  std::string console;   ///< log lines of the page's console
};

Visit visit(const fs::path& page, const fs::path& profile, int width_px, Scheme scheme, int virtual_milliseconds = kVirtualMilliseconds) {
  const ProcessResult result =
      run_process(program_on_path("chromium"),
                  {"--headless", "--no-sandbox", "--disable-gpu", "--user-data-dir=" + profile.string(),
                   "--window-size=" + std::to_string(width_px) + ",900",
                   "--blink-settings=preferredColorScheme=" + std::to_string(static_cast<int>(scheme)), "--enable-logging=stderr",
                   "--virtual-time-budget=" + std::to_string(virtual_milliseconds), "--dump-dom", "file://" + page.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  Visit visit{result.out, {}};
  std::istringstream log(result.err);
  for (std::string line; std::getline(log, line);)
    if (line.find("CONSOLE") != std::string::npos) visit.console += line + "\n";
  return visit;
}

/// Null when the probe has not come to its end.
nlohmann::json probe_result(const Visit& visit) {
  const std::string start = "<pre id=\"probe\">";
  const std::size_t at = visit.document.find(start);
  if (at == std::string::npos) return nullptr;
  const std::size_t from = at + start.size();
  return nlohmann::json::parse(visit.document.substr(from, visit.document.find("</pre>", from) - from), nullptr, false);
}

class Report : public testing::Test {
 protected:
  void SetUp() override {
    if (program_on_path("chromium").empty())
      GTEST_SKIP() << "chromium is not installed (third_party/install does that): the report is not opened";
    const fs::path plant = folder_ / "hazel.glb", html = folder_ / "hazel.html";
    ASSERT_EQ(run_process(COPPICE_TOOL, {"plant", "corylus", "-o", plant}).exit_code, 0);
    const ProcessResult result =
        run_process(COPPICE_TOOL, {"evaluate", plant, "--methods", "geometric,stochastic", "--levels", ".4,.1,.05", "--html", html});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::ifstream file(html, std::ios::binary);
    page_.assign(std::istreambuf_iterator<char>(file), {});
  }

  /// The page with `addition` at the end of its body.
  fs::path page_with(const std::string& addition) {
    const std::size_t at = page_.rfind("</body>");
    EXPECT_NE(at, std::string::npos);
    std::ofstream(folder_ / "page.html", std::ios::binary) << page_.substr(0, at) << addition << page_.substr(at);
    return folder_ / "page.html";
  }

  nlohmann::json probe(int width_px, Scheme scheme) {
    const fs::path page = page_with(kProbe);
    nlohmann::json found;
    for (int attempt = 0, milliseconds = kVirtualMilliseconds; attempt < kAttempts && !found.is_object(); ++attempt, milliseconds *= 4) {
      const Visit seen = visit(page, folder_ / "profile", width_px, scheme, milliseconds);
      EXPECT_EQ(seen.console, "");
      found = probe_result(seen);
    }
    EXPECT_TRUE(found.is_object()) << "the page was never drawn";
    return found;
  }

  TemporaryFolder folder_;
  std::string page_;
};

TEST_F(Report, DrawsEverythingAndItsControlsWork) {
  const nlohmann::json found = probe(1400, Scheme::light);
  ASSERT_TRUE(found.is_object());
  EXPECT_EQ(found["plant"], "hazel");
  EXPECT_EQ(found["title"], "hazel: Coppice evaluation");
  EXPECT_EQ(found["overflow"], 0);
  ASSERT_EQ(found["inked"].size(), 10u) << "one canvas a chart";
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_GT(found["inked"][i], 1000);
    EXPECT_LT(found["inked_after"][i], found["inked"][i]) << "a method that is switched off leaves its chart";
  }
  EXPECT_EQ(found["pressed"], "false");
  EXPECT_EQ(found["pictures"], 3) << "the source and two methods";
  EXPECT_EQ(found["pictures_after"], 3) << "one a level";
  EXPECT_EQ(found["shrunk"], 64);
  EXPECT_EQ(found["same"], 0) << "pixels by which the source differs from itself";
  EXPECT_GT(found["different"], 100);
  EXPECT_EQ(found["rows"], 3);
  EXPECT_GE(found["best"], 3);
  EXPECT_EQ(found["sentences"], 5);
  EXPECT_NE(found["caption"].get<std::string>().find("crown"), std::string::npos) << found["caption"];
}

TEST_F(Report, FollowsTheSystemsColoursUntilToldOtherwise) {
  const nlohmann::json light = probe(1400, Scheme::light), dark = probe(1400, Scheme::dark);
  ASSERT_TRUE(light.is_object() && dark.is_object());
  EXPECT_NE(light["background"], dark["background"]);
  for (const nlohmann::json& found : {light, dark}) {
    EXPECT_EQ(found["light"], light["background"]);
    EXPECT_EQ(found["dark"], dark["background"]);
  }
}

TEST_F(Report, FitsANarrowWindow) {
  const nlohmann::json found = probe(420, Scheme::dark);
  ASSERT_TRUE(found.is_object());
  EXPECT_LE(found["width"], 500) << "the browser did not make the window narrow";
  EXPECT_EQ(found["overflow"], 0) << "the page scrolls sideways";
}

TEST_F(Report, MistakesWouldBeSeen) {
  const fs::path profile = folder_ / "profile";
  EXPECT_NE(visit(page_with("<script>undefined_function();</script>"), profile, 800, Scheme::light).console, "");
  EXPECT_NE(visit(page_with("<img src=\"https://example.invalid/picture.png\">"), profile, 800, Scheme::light).console, "")
      << "the page's policy does not stop loads";
}

}  // namespace
