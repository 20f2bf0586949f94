// The page of `coppice bake-all --html`: its pictures, and what it shows in headless Chromium.

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "browser.h"
#include "gltf_builder.h"
#include "image_decode.h"
#include "tool.h"

namespace coppice::test::batch_page_test {

namespace fs = std::filesystem;

constexpr const char* kProbe = R"probe(
<pre id="probe"></pre>
<script>
(async () => {
  const pause = () => new Promise(resolve => setTimeout(resolve, 20));
  while (document.documentElement.dataset.report !== 'ready') await pause();
  const cards = () => [...document.querySelectorAll('.plant')], names = () => cards().map(card => card.querySelector('strong').textContent);
  const set = (id, value) => { document.getElementById(id).value = value; document.getElementById(id).dispatchEvent(new Event('input')); };
  const images = [...document.querySelectorAll('.plant img')];
  await Promise.all(images.map(image => image.decode()));
  const found = {
    title: document.title,
    summary: document.getElementById('summary').textContent,
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    names: names(),
    sizes: images.map(image => `${image.naturalWidth}x${image.naturalHeight}`),
    failures: [...document.querySelectorAll('.failure')].map(failure => failure.textContent),
    injected: document.querySelectorAll('main b').length,
  };
  set('find', 'SMALL');
  found.found = names();
  set('find', '');
  set('show', 'failed');
  found.failed = names();
  set('show', 'all');
  set('sort', 'leaves');
  found.by_leaves = names();
  images[0]?.click();
  document.querySelector('.plant img')?.click();
  found.enlarged = document.getElementById('large').open;
  document.getElementById('probe').textContent = JSON.stringify(found);
})();
</script>
)probe";

class BatchPage : public testing::Test {
 protected:
  /// A hazel, the smallest plant under a name that is markup, and a file that is no plant.
  void SetUp() override {
    fs::create_directories(plants_);
    ASSERT_EQ(run_tool({"plant", "corylus", "-o", plants_ / "hazel.glb"}).exit_code, 0);
    write_file(plants_ / "small<b>.glb", small_plant().glb());
    write_text(plants_ / "letter.glb", "this is a letter, not a plant\n");
  }

  /// Bakes, and expects the failure of the letter.
  void bake_all(const Words& more) {
    EXPECT_EQ(run_tool(joined({"bake-all", plants_, "-o", out_, "--views", "2", "--resolution", "16"}, more)).exit_code, 1);
  }

  /// The pictures' bytes by their names.
  [[nodiscard]] std::map<std::string, std::string> pictures() const {
    const fs::path folder = out_ / ".coppice-pictures";
    return fs::exists(folder) ? outputs(folder) : std::map<std::string, std::string>{};
  }

  nlohmann::json probe(int width_px = 1400) {
    return probed_page(page_with(read_text(page_), kProbe, folder_ / "probed.html"), folder_ / "profile", width_px, Scheme::light);
  }

  TemporaryFolder folder_;
  fs::path plants_ = folder_ / "plants", out_ = folder_ / "out", page_ = folder_ / "page.html";
};

TEST_F(BatchPage, APictureShowsThePlantNearAndFar) {
  bake_all({});
  EXPECT_TRUE(pictures().empty()) << "nobody asked for them";
  bake_all({"--html", page_});
  const auto drawn = pictures();
  ASSERT_EQ(drawn.size(), 2u);
  for (const auto& [name, bytes] : drawn) {
    const auto image = bake::decode_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, 4096);
    ASSERT_TRUE(image);
    ASSERT_EQ(image->width, 288u);
    ASSERT_EQ(image->height, 224u);
    // Pixels that are no background, near and far.
    std::size_t near = 0, far = 0;
    for (std::size_t pixel = 0; pixel < std::size_t{288} * 224; ++pixel) {
      const std::uint8_t* rgba = &image->rgba[4 * pixel];
      if (std::abs(rgba[0] - image->rgba[0]) + std::abs(rgba[1] - image->rgba[1]) + std::abs(rgba[2] - image->rgba[2]) < 40) continue;
      ++(pixel % 288 < 224 ? near : far);
    }
    EXPECT_GT(near, 500u);
    EXPECT_GT(far, 50u);
    EXPECT_LT(far, std::size_t{64} * 64) << "it is not below the plant alone";
  }
  fs::remove_all(out_ / ".coppice-pictures");
  bake_all({"--pictures", "--jobs", "1"});
  EXPECT_EQ(pictures(), drawn) << "of cached plants, and the same bytes";
}

TEST_F(BatchPage, ShowsEveryPlant) {
  if (program_on_path("chromium").empty())
    GTEST_SKIP() << "chromium is not installed (third_party/install does that): the page is not opened";
  bake_all({"--html", page_});
  const nlohmann::json found = probe();
  ASSERT_TRUE(found.is_object());
  EXPECT_TRUE(mentions(found["title"].get<std::string>(), {out_.string()}));
  EXPECT_TRUE(mentions(found["summary"].get<std::string>(), {"2", "0", "1"}));
  EXPECT_EQ(found["overflow"], 0);
  // Chromium prints the text as markup.
  EXPECT_EQ(found["names"], nlohmann::json({"hazel", "letter", "small&lt;b&gt;"}));
  EXPECT_EQ(found["sizes"], nlohmann::json({"288x224", "288x224"}));
  ASSERT_EQ(found["failures"].size(), 1u);
  EXPECT_TRUE(mentions(found["failures"][0].get<std::string>(), {"letter"}));
  EXPECT_EQ(found["injected"], 0) << "a name became markup";
  EXPECT_EQ(found["found"], nlohmann::json({"small&lt;b&gt;"}));
  EXPECT_EQ(found["failed"], nlohmann::json({"letter"}));
  EXPECT_EQ(found["by_leaves"], nlohmann::json({"hazel", "small&lt;b&gt;", "letter"}));
  EXPECT_EQ(found["enlarged"], true);
  const nlohmann::json narrow = probe(420);
  ASSERT_TRUE(narrow.is_object());
  EXPECT_EQ(narrow["overflow"], 0) << "the page scrolls sideways";
}

}  // namespace coppice::test::batch_page_test
