// Labels painted by Pango. The glyphs depend on the font; these tests check where pixels are
// painted, and that equal text gives equal pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "elements/tensor_overlay/overlay_test_support.hpp"
#include "elements/tensor_overlay/text_painter.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::overlay_test {
namespace overlay_text_test {

constexpr int kWidth = 400, kHeight = 100;

class OverlayText : public testing::Test {
 protected:
  void SetUp() override {
    const auto painter = make_text_painter(20);
    if (!painter) GTEST_SKIP() << painter.error().message();
    std::ofstream(path_) << "cat\na horse, of course\n";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  // A white picture with the label of one box at 50,40.
  Bytes with_label(const std::string& properties, float score, float class_index) const {
    const auto element = lone_element("tensor_overlay line-width=0 auto-size=false " + properties);
    const Harness results{gst_harness_new_with_element(element.get(), "results", nullptr)};
    const Harness pictures{gst_harness_new_with_element(element.get(), "sink", "src")};
    gst_harness_set_src_caps_str(results.get(), floats(6, 1).c_str());
    gst_harness_set_src_caps_str(pictures.get(), video("GRAY8", kWidth, kHeight).c_str());
    gst_harness_push(results.get(), frame<float>({50, 40, 90, 90, score, class_index}, 0));
    const auto out = Ref<GstBuffer>::adopt(
        gst_harness_push_and_pull(pictures.get(), frame(Bytes(kWidth * kHeight, 255), 0)));
    return content(out.get());
  }
  std::string labels() const { return "labels=" + path_ + " "; }
  // Counts pixels that are not white; all must be within the columns and rows of a label.
  static int labelled(const Bytes& picture) {
    int count = 0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      if (picture[static_cast<size_t>(i)] == 255) continue;
      ++count;
      EXPECT_GE(i % kWidth, 50);
      EXPECT_GE(i / kWidth, 5);
      EXPECT_LT(i / kWidth, 40);
    }
    return count;
  }
  // Counts those that are darker than any class colour.
  static int inked(const Bytes& picture) {
    int count = 0;
    for (const uint8_t pixel : picture) count += pixel < 30;
    return count;
  }

  const std::string path_ =
      testing::TempDir() + "weir-overlay-" + std::to_string(getpid()) + ".txt";
};

TEST_F(OverlayText, IsNameAndScore) {
  const auto both = with_label(labels(), 0.87f, 0);
  const auto name = with_label(labels() + "show-scores=false", 0.87f, 0);
  const auto score = with_label("", 0.87f, 0);
  EXPECT_GT(inked(name), 20);
  EXPECT_GT(inked(score), 20);
  EXPECT_EQ(inked(both), inked(name) + inked(score));
  EXPECT_GT(labelled(both), labelled(name));
  EXPECT_LT(labelled(both), labelled(name) + labelled(score));
  EXPECT_EQ(both, with_label(labels(), 0.8701f, 0));
  EXPECT_NE(both, with_label(labels(), 0.78f, 0));
}

TEST_F(OverlayText, IsTheNameOfItsClass) {
  const std::string names_only = labels() + "show-scores=false";
  const auto cat = with_label(names_only, 1, 0), horse = with_label(names_only, 1, 1);
  EXPECT_GT(labelled(horse), 2 * labelled(cat));
  EXPECT_GT(inked(with_label(names_only, 1, 2)), 10);  // "2"
  EXPECT_EQ(labelled(with_label("show-scores=false", 1, 0)), 0);
}

// The label of a box in a stream that says its columns and source; `labels` may come with it.
Bytes with_stream_labels(const std::string& properties,
                         const std::vector<gst::LabelsOfSource>& labels) {
  const auto element = lone_element("tensor_overlay line-width=0 auto-size=false " + properties);
  const Harness results{gst_harness_new_with_element(element.get(), "results", nullptr)};
  const Harness pictures{gst_harness_new_with_element(element.get(), "sink", "src")};
  gst_harness_set_src_caps_str(
      results.get(),
      (floats(6, 1) + ",weir-columns=(string)\"x1,y1,x2,y2,score,class\",weir-source=(string)yolo")
          .c_str());
  gst_harness_set_src_caps_str(pictures.get(), video("GRAY8", kWidth, kHeight).c_str());
  for (const auto& one : labels)
    gst_harness_push_event(results.get(), gst::make_labels_event(one).release());
  gst_harness_push(results.get(), frame<float>({50, 40, 90, 90, 0.87f, 0}, 0));
  const auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(pictures.get(), frame(Bytes(kWidth * kHeight, 255), 0)));
  return content(out.get());
}

TEST_F(OverlayText, IsTheNameThatCameWithTheResults) {
  const auto named = with_label(labels(), 0.87f, 0), score = with_label("", 0.87f, 0);
  EXPECT_EQ(with_stream_labels("", {{"yolo", {"cat"}}}), named);
  EXPECT_EQ(with_stream_labels("", {{"other", {"horse"}}}), score);
  EXPECT_EQ(with_stream_labels("", {{"other", {"horse"}}, {"yolo", {"cat"}}}), named);
  EXPECT_EQ(with_stream_labels(labels(), {{"yolo", {"horse"}}}), named) << "the user's count";
}

TEST_F(OverlayText, HasTheConfiguredSize) {
  const auto small = with_label(labels() + "text-size=10", 1, 0);
  const auto large = with_label(labels() + "text-size=25", 1, 0);
  EXPECT_GT(labelled(large), 4 * labelled(small));
}

TEST_F(OverlayText, EndsInAnEllipsisIfTooLong) {
  const auto painter = *make_text_painter(10);
  const auto one = painter->paint("x"), many = painter->paint(std::string(10000, 'x'));
  EXPECT_LE(many.width, 300u);
  EXPECT_GT(many.width, 250u);
  EXPECT_EQ(many.height, one.height);
  EXPECT_EQ(many.coverage.size(), size_t{many.width} * many.height);
}

TEST_F(OverlayText, OfEveryScriptHasOneHeight) {
  const auto painter = *make_text_painter(16);
  const auto height = painter->paint("a").height;
  for (const char* text : {"", "Ä", "人", "नमस्ते", "العربية", "two\nlines", "\u2028"}) {
    const auto mask = painter->paint(text);
    EXPECT_EQ(mask.height, height) << text;
    EXPECT_EQ(mask.coverage.size(), size_t{mask.width} * height) << text;
  }
  EXPECT_EQ(painter->paint("").width, 0u);
}

// fontconfig reads its files once per process.
TEST(OverlayTextDeathTest, NeedsAFont) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const std::string path =
      testing::TempDir() + "weir-no-fonts-" + std::to_string(getpid()) + ".conf";
  std::ofstream(path) << "<?xml version=\"1.0\"?><fontconfig></fontconfig>";
  EXPECT_EXIT(
      {
        setenv("FONTCONFIG_FILE", path.c_str(), 1);
        const std::string text = start_error("tensor_overlay labels=" + path);
        const auto has = [&](const char* words) { return text.find(words) != std::string::npos; };
        const bool no_font = has("WEIR-4001: labels cannot be drawn") && has("offered: no font") &&
                             has("fix: apt-get install fonts-dejavu-core");
        std::filesystem::remove(path);
        std::_Exit(no_font || has("without Pango") || has("libpangocairo-1.0-0") ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
  std::filesystem::remove(path);
}

}  // namespace overlay_text_test
}  // namespace weir::overlay_test
