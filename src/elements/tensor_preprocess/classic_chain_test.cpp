// Compares tensor_preprocess with the elements it replaces: the same tensor for each model card.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "core/card/card.hpp"
#include "core/tensor/element_type.hpp"
#include "gstcpp/element/ref.hpp"

namespace classic_chain_test {

using weir::ElementType;
using weir::gst::Mapped;
using weir::gst::Ref;
using weir::gst::Unique;

struct Output {
  std::string caps;
  std::vector<std::byte> bytes;
};

// The last frame of a pipeline.
Output last_frame(const std::string& elements) {
  Output out;
  const auto pipeline = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_parse_launch(
      (elements + " ! other/tensors,format=static ! appsink name=out sync=false").c_str(),
      nullptr))));
  const auto sink = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  while (GstSample* raw = gst_app_sink_pull_sample(GST_APP_SINK(sink.get()))) {
    const Unique<GstSample, gst_sample_unref> sample(raw);
    const Mapped map(gst_sample_get_buffer(raw), GST_MAP_READ);
    out.bytes.assign(map.bytes().begin(), map.bytes().end());
    out.caps = weir::gst::UniqueText(gst_caps_to_string(gst_sample_get_caps(raw))).get();
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return out;
}

struct ReadCard {
  std::string path;
  weir::card::ImageInput input;
};

std::vector<ReadCard> cards() {
  std::vector<ReadCard> out;
  const char* models = std::getenv("WEIR_MODELS");
  if (!models) return out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(models)) {
    const std::string path = entry.path().string();
    if (!path.ends_with(".card.json")) continue;
    const auto card = weir::card::read(path);
    // A letterbox has no classic chain.
    if (card && card->inputs[0].resize != weir::card::Fit::Letterbox)
      out.push_back({path, card->inputs[0]});
  }
  return out;
}

std::string video(const ReadCard& card, const std::string& format, const char* pattern = "smpte") {
  return std::string("videotestsrc num-buffers=2 pattern=") + pattern +
         " ! video/x-raw,width=" + std::to_string(card.input.width()) +
         ",height=" + std::to_string(card.input.height()) +
         ",pixel-aspect-ratio=1/1,format=" + format + " ! ";
}

double number_at(const Output& out, ElementType type, size_t index) {
  return weir::visit_type(type, [&](auto tag) {
    typename decltype(tag)::type value;
    std::memcpy(&value, out.bytes.data() + index * sizeof value, sizeof value);
    return static_cast<double>(value);
  });
}

// The difference of one pixel level, in values of the tensor.
double get_step(const weir::card::ImageInput& input) {
  double step = input.scale.empty() ? 1 : 0;
  for (const double scale : input.scale) step = std::max(step, std::fabs(scale));
  return step;
}

TEST(ClassicChain, GivesTheSameBytesFromPixelsOfTheCardsSize) {
  size_t compared = 0;
  for (const auto& card : cards()) {
    const bool gray = card.input.color == weir::card::Color::Gray;
    for (const char* format : {"RGB", "BGRx", "ARGB", "GRAY8"}) {
      if (gray && std::string(format) != "GRAY8") continue;
      SCOPED_TRACE(card.path + " from " + format);
      const Output classic = last_frame(video(card, format) + weir::card::preparation(card.input));
      const Output one = last_frame(video(card, format) + "tensor_preprocess card=" + card.path);
      ASSERT_FALSE(classic.bytes.empty());
      EXPECT_TRUE(one.bytes == classic.bytes);
      ++compared;
    }
  }
  EXPECT_GE(compared, 9u * 3);
}

TEST(ClassicChain, IsWithinOneStepWhereItRoundsBetween) {
  for (const auto& card : cards()) {
    const bool gray = card.input.color == weir::card::Color::Gray;
    // Gray content of full range: at chroma edges and in limited range, videoconvert's
    // approximations are off by more than one level.
    const std::string source =
        gray ? video(card, "RGB")
             : video(card, "NV12,colorimetry=1:4:5:1", "zone-plate kx2=20 ky2=20 kt=1");
    SCOPED_TRACE(card.path);
    const Output classic = last_frame(source + weir::card::preparation(card.input));
    const Output one = last_frame(source + "tensor_preprocess card=" + card.path);
    ASSERT_FALSE(classic.bytes.empty());
    ASSERT_EQ(one.bytes.size(), classic.bytes.size());
    // The classic chain rounded its pixels by up to half a level.
    const size_t count = one.bytes.size() / weir::element_size(card.input.type);
    for (size_t i = 0; i < count; ++i)
      ASSERT_NEAR(number_at(one, card.input.type, i), number_at(classic, card.input.type, i),
                  1.5 * get_step(card.input));
  }
}

}  // namespace classic_chain_test
