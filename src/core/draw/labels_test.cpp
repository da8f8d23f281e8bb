// Which texts are painted, and how often.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/labels.hpp"

#include <gtest/gtest.h>

namespace weir::draw {
namespace labels_test {

// A mask as wide as the text is long; its coverage is the first byte of the text.
class LengthPainter : public TextPainter {
 public:
  explicit LengthPainter(std::vector<std::string>* texts) : texts_(*texts) {}
  Mask paint(const std::string& text) override {
    texts_.push_back(text);
    const auto width = static_cast<uint32_t>(text.size());
    return {width, 1, std::vector<uint8_t>(width, static_cast<uint8_t>(text[0]))};
  }

 private:
  std::vector<std::string>& texts_;
};

Labels labels(std::vector<std::string> names, bool scores, std::vector<std::string>* texts) {
  return Labels({std::move(names)}, scores, std::make_unique<LengthPainter>(texts),
                *preprocess::picture_format("GRAY8"));
}

TEST(Labels, AreNamesOfClassesPaintedOnce) {
  std::vector<std::string> texts;
  auto l = labels({"cat", "horse"}, false, &texts);
  EXPECT_TRUE(texts.empty());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(l.name(0, 1)->width, 5u);
    EXPECT_EQ(l.name(0, 0)->planes[0].coverage[0], 'c');
  }
  EXPECT_EQ(texts, (std::vector<std::string>{"horse", "cat"}));
  EXPECT_EQ(l.score(0.5f), nullptr);
}

TEST(Labels, OfClassesWithoutANameAreNumbers) {
  std::vector<std::string> texts;
  auto l = labels({"cat"}, false, &texts);
  l.name(0, 12);
  EXPECT_EQ(texts, (std::vector<std::string>{"12"}));
  for (uint32_t i = 0; i < 10000; ++i) {
    l.begin_picture();
    EXPECT_EQ(l.name(0, i)->height, 1u);
  }
  EXPECT_EQ(l.name(0, UINT32_MAX)->width, 10u);
  std::vector<std::string> none;
  EXPECT_EQ(labels({}, true, &none).name(0, 0), nullptr);
}

TEST(Labels, OfEachSourceHaveTheirOwnNames) {
  std::vector<std::string> texts;
  Labels l({{"cat"}, {}, {"tabby", "lion"}}, false, std::make_unique<LengthPainter>(&texts),
           *preprocess::picture_format("GRAY8"));
  EXPECT_EQ(l.name(0, 0)->width, 3u);
  EXPECT_EQ(l.name(1, 0), nullptr);
  EXPECT_EQ(l.name(2, 1)->width, 4u);
  EXPECT_EQ(l.name(3, 0), nullptr);
}

TEST(Labels, TextsStayValidWithinAPicture) {
  std::vector<std::string> texts;
  auto l = labels({}, false, &texts);
  l.begin_picture();
  const PlaneMask* first = l.text("first");
  for (int i = 0; i < 10000; ++i) l.text(std::to_string(i));
  EXPECT_EQ(l.text("first"), first);
  EXPECT_EQ(first->width, 5u);
}

TEST(Labels, ShowScoresInPerCent) {
  std::vector<std::string> texts;
  const auto l = labels({}, true, &texts);
  EXPECT_EQ(texts.size(), 101u);
  EXPECT_EQ(texts[87], "87 %");
  const auto width = [&](float score) { return l.score(score)->width; };
  EXPECT_EQ(width(0.094f), 3u);   // "9 %"
  EXPECT_EQ(width(0.0951f), 4u);  // "10 %"
  EXPECT_EQ(width(0.99f), 4u);
  EXPECT_EQ(width(0.996f), 5u);
  EXPECT_EQ(width(37), 5u);  // clamped to 100 %
  EXPECT_EQ(width(1e-30f), 3u);
}

}  // namespace labels_test
}  // namespace weir::draw
