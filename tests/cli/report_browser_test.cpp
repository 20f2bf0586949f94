// The report of `coppice evaluate --html` in headless Chromium. A probe is appended to a copy of the page; it waits until the page is
// drawn, uses its controls and writes what it finds as JSON into the document, which Chromium prints. Anything on the console fails.

#include <filesystem>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "browser.h"
#include "made_once.h"
#include "tool.h"

namespace coppice::test::report_browser_test {

namespace fs = std::filesystem;

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
    caption_before: document.querySelector('#table caption').textContent,
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

class Report : public testing::Test {
 protected:
  void SetUp() override {
    if (program_on_path("chromium").empty())
      GTEST_SKIP() << "chromium is not installed (third_party/install does that): the report is not opened";
    const fs::path made = made_once("hazel_report", [](const fs::path& kept) {
      const fs::path plant = kept / "hazel.glb", html = kept / "hazel.html";
      fs::copy_file(corylus_glb(), plant);
      const ProcessResult result =
          run_tool({"evaluate", plant, "--methods", "geometric,stochastic", "--levels", ".4,.1,.05", "--html", html});
      if (result.exit_code != 0) throw std::runtime_error("coppice evaluate: " + result.err);
    });
    page_ = read_text(made / "hazel.html");
  }

  fs::path with(const std::string& addition) { return page_with(page_, addition, folder_ / "page.html"); }

  nlohmann::json probe(int width_px, Scheme scheme) { return probed_page(with(kProbe), folder_ / "profile", width_px, scheme); }

  TemporaryFolder folder_;
  std::string page_;
};

TEST_F(Report, DrawsEverythingAndItsControlsWork) {
  const nlohmann::json found = probe(1400, Scheme::light);
  ASSERT_TRUE(found.is_object());
  EXPECT_EQ(found["plant"], "hazel");
  EXPECT_TRUE(mentions(found["title"].get<std::string>(), {"hazel"}));
  EXPECT_EQ(found["overflow"], 0);
  ASSERT_EQ(found["inked"].size(), 13u) << "one canvas a chart";
  for (std::size_t i = 0; i < 13; ++i) {
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
  EXPECT_EQ(found["sentences"], 8);
  EXPECT_NE(found["caption"], found["caption_before"]) << "another measure was chosen";
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
  EXPECT_NE(visit(with("<script>undefined_function();</script>"), profile, 800, Scheme::light).console, "");
  EXPECT_NE(visit(with("<img src=\"https://example.invalid/picture.png\">"), profile, 800, Scheme::light).console, "")
      << "the page's policy does not stop loads";
}

}  // namespace coppice::test::report_browser_test
