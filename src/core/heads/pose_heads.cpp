// Heads of networks that output the key points of persons: MoveNet, PoseNet, and one heat map for
// each key point, as HRNet has.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/detection/posenet.hpp"
#include "core/heads/families.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;

constexpr size_t kPoints = 17, kPointValues = 3;
constexpr size_t kPersonValues = kPoints * kPointValues + 5;  // then a box and its score

// Fills `points` and returns their mean score.
float read_points(const float* values, Size input, std::vector<results::KeyPoint>* points) {
  points->clear();
  float sum = 0;
  for (size_t i = 0; i < kPoints; ++i, values += kPointValues) {
    points->push_back(key_point(values[1] * static_cast<float>(input.width),
                                values[0] * static_cast<float>(input.height), values[2]));
    sum += points->back().score;
  }
  return sum / static_cast<float>(kPoints);
}

class Movenet final : public PointsHead {
 public:
  explicit Movenet(float threshold) : PointsHead(kPoints), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, Size input) override {
    need_input_size(input);
    begin();
    const float score = read_points(outputs.read(0).data(), input, &points_);
    if (score >= threshold_ && score > 0) add(points_, threshold_, score, 0);
    return take();
  }

 private:
  float threshold_;
  std::vector<results::KeyPoint> points_;
};

class Multipose final : public PointsHead {
 public:
  Multipose(size_t persons, float threshold)
      : PointsHead(kPoints), persons_(persons), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, Size input) override {
    need_input_size(input);
    begin();
    const auto width = static_cast<float>(input.width), height = static_cast<float>(input.height);
    for (size_t i = 0; i < persons_; ++i) {
      const float* person = outputs.read(0).data() + i * kPersonValues;
      const float* box = person + kPoints * kPointValues;  // y1, x1, y2, x2, score
      const float score = to_probability(box[4]);
      if (!(score >= threshold_) || score == 0) continue;
      read_points(person, input, &points_);
      add(points_, Box{box[1] * width, box[0] * height, box[3] * width, box[2] * height}, score);
    }
    return take();
  }

 private:
  size_t persons_;
  float threshold_;
  std::vector<results::KeyPoint> points_;
};

bool is_movenet(const ModelSignature& model) {
  return model.outputs.size() == 1 && matrix_rows(model.outputs[0], kPointValues) == kPoints;
}
size_t count_persons(const ModelSignature& model) {
  return model.outputs.size() == 1 ? matrix_rows(model.outputs[0], kPersonValues) : 0;
}

Match fit_movenet(const ModelSignature& model) {
  return is_movenet(model) ? Match::Possible : Match::No;
}
Match fit_multipose(const ModelSignature& model) {
  return count_persons(model) > 0 ? Match::Possible : Match::No;
}
std::unique_ptr<Head> open_movenet(const ModelSignature& model, const HeadOptions& options) {
  if (!is_movenet(model)) throw wrong_outputs(model, kMovenet);
  return std::make_unique<Movenet>(options.threshold);
}
std::unique_ptr<Head> open_multipose(const ModelSignature& model, const HeadOptions& options) {
  const size_t persons = count_persons(model);
  if (persons == 0) throw wrong_outputs(model, kMovenetMultipose);
  return std::make_unique<Multipose>(persons, options.threshold);
}

using detection::Candidates;
using detection::kPoseNetEdges;
using detection::kPoseNetPoints;
using detection::PoseNetMaps;

struct PoseNetLayout {
  size_t width, height;  // cells
  size_t heat, offsets;  // outputs
  // With both vectors in one output, and with one output for each; or neither.
  std::optional<size_t> vectors, forward, backward;
};

// The outputs VALUES:width:height, in their order.
std::vector<size_t> find_grids(const ModelSignature& model, size_t values, size_t width,
                               size_t height) {
  std::vector<size_t> found;
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const Shape& shape = model.outputs[i].shape;
    if (shape.min_rank() <= 3 &&
        shape == Shape{static_cast<uint32_t>(values), static_cast<uint32_t>(width),
                       static_cast<uint32_t>(height)})
      found.push_back(i);
  }
  return found;
}

// Where output `heat` has the heat maps; nullopt if it cannot have them.
std::optional<PoseNetLayout> layout_around(const ModelSignature& model, size_t heat) {
  const Shape& shape = model.outputs[heat].shape;
  if (shape[0] != kPoseNetPoints || shape[1] < 2 || shape[2] < 2) return std::nullopt;
  const auto grids = [&](size_t values) { return find_grids(model, values, shape[1], shape[2]); };
  const auto offsets = grids(2 * kPoseNetPoints);
  if (offsets.size() != 1 || grids(kPoseNetPoints).size() != 1) return std::nullopt;
  PoseNetLayout layout{.width = shape[1],
                       .height = shape[2],
                       .heat = heat,
                       .offsets = offsets[0],
                       .vectors = {},
                       .forward = {},
                       .backward = {}};
  if (const auto both = grids(4 * kPoseNetEdges); both.size() == 1) layout.vectors = both[0];
  if (const auto one = grids(2 * kPoseNetEdges); one.size() == 2) {
    const bool is_swapped = has_name_with(model.outputs[one[0]], "bwd");
    layout.forward = one[is_swapped ? 1 : 0], layout.backward = one[is_swapped ? 0 : 1];
  }
  return layout;
}

std::optional<PoseNetLayout> posenet_layout(const ModelSignature& model) {
  for (size_t i = 0; i < model.outputs.size(); ++i)
    if (const auto layout = layout_around(model, i)) return layout;
  return std::nullopt;
}

class Posenet final : public PointsHead {
 public:
  Posenet(const PoseNetLayout& layout, float threshold)
      : PointsHead(kPoseNetPoints), layout_(layout), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, Size input) override {
    need_input_size(input);
    const PoseNetMaps maps = read_maps(outputs, input);
    begin();
    if (!maps.forward.values.empty()) {
      for (const auto& person : find_people(maps, threshold_)) add_person(person);
    } else if (const auto person = best_person(maps); person.score >= threshold_) {
      add_person(person);
    }
    return take();
  }

 private:
  PoseNetMaps read_maps(OutputValues& outputs, Size input) const {
    // The first and the last cells are at the first and the last pixels.
    const auto stride = [](uint32_t pixels, size_t cells) {
      return pixels > 1 ? static_cast<float>(pixels - 1) / static_cast<float>(cells - 1) : 1.0f;
    };
    PoseNetMaps maps{.width = layout_.width,
                     .height = layout_.height,
                     .stride_x = stride(input.width, layout_.width),
                     .stride_y = stride(input.height, layout_.height),
                     .heat = outputs.read(layout_.heat),
                     .offsets = outputs.read(layout_.offsets),
                     .forward = {},
                     .backward = {}};
    constexpr size_t kEdges = kPoseNetEdges;
    if (layout_.vectors) {
      const auto values = outputs.read(*layout_.vectors);
      maps.forward = {.values = values, .per_cell = 4 * kEdges, .y = 0, .x = kEdges};
      maps.backward = {.values = values, .per_cell = 4 * kEdges, .y = 2 * kEdges, .x = 3 * kEdges};
    } else if (layout_.forward) {
      maps.forward = {
          .values = outputs.read(*layout_.forward), .per_cell = 2 * kEdges, .y = 0, .x = kEdges};
      maps.backward = {
          .values = outputs.read(*layout_.backward), .per_cell = 2 * kEdges, .y = 0, .x = kEdges};
    }
    return maps;
  }

  void add_person(const detection::PoseNetPerson& person) {
    std::vector<results::KeyPoint> points;
    for (const auto& point : person.points)
      points.push_back(key_point(point.x, point.y, point.score));
    if (person.score > 0) add(points, threshold_, person.score, 0);
  }

  PoseNetLayout layout_;
  float threshold_;
};

Match fit_posenet(const ModelSignature& model) {
  if (!posenet_layout(model)) return Match::No;
  return any_name_has(model, "heatmap") && any_name_has(model, "offset") ? Match::Certain
                                                                         : Match::Possible;
}

std::unique_ptr<Head> open_posenet(const ModelSignature& model, const HeadOptions& options) {
  const auto layout = posenet_layout(model);
  if (!layout) throw wrong_outputs(model, kPosenet);
  return std::make_unique<Posenet>(*layout, options.threshold);
}

using detection::Candidates;

struct Layout {
  size_t points, width, height;
  size_t next_point, next_cell;  // elements from one to the next
};

constexpr size_t kMinSide = 8, kMaxPoints = 512;

// Whether the cells of such maps are squares of the input. One map of the input's own size is a
// mask or a depth.
bool is_plausible(const Layout& layout, Size input) {
  if (layout.width < kMinSide || layout.height < kMinSide || layout.points > kMaxPoints)
    return false;
  if (input.width == 0 || input.height == 0)
    return layout.points > 1 && layout.points < layout.width && layout.points < layout.height;
  return input.width % layout.width == 0 &&
         input.width / layout.width * layout.height == input.height;
}

// Planar maps if both orders are plausible.
std::optional<Layout> find_layout(const ModelSignature& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  if (shape.min_rank() > 3 || shape.rank() < 3) return std::nullopt;
  const size_t a = shape[0], b = shape[1], c = shape[2];
  const Layout planar{.points = c, .width = a, .height = b, .next_point = a * b, .next_cell = 1};
  const Layout packed{.points = a, .width = b, .height = c, .next_point = 1, .next_cell = a};
  if (is_plausible(planar, model.input)) return planar;
  if (is_plausible(packed, model.input)) return packed;
  return std::nullopt;
}

class HeatMaps final : public PointsHead {
 public:
  HeatMaps(const Layout& layout, float threshold)
      : PointsHead(layout.points), layout_(layout), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, Size input) override {
    need_input_size(input);
    const auto maps = outputs.read(0);
    const float scale_x = static_cast<float>(input.width) / static_cast<float>(layout_.width);
    const float scale_y = static_cast<float>(input.height) / static_cast<float>(layout_.height);
    begin();
    points_.clear();
    float sum = 0;
    for (size_t i = 0; i < layout_.points; ++i) {
      const float* map = maps.data() + i * layout_.next_point;
      const size_t peak = find_peak(map);
      const size_t column = peak % layout_.width, row = peak / layout_.width;
      float x = static_cast<float>(column), y = static_cast<float>(row);
      if (column > 1 && column + 1 < layout_.width && row > 1 && row + 1 < layout_.height) {
        x += 0.25f * step(map, peak, 1);
        y += 0.25f * step(map, peak, layout_.width);
      }
      points_.push_back(key_point(x * scale_x, y * scale_y, map[peak * layout_.next_cell]));
      sum += points_.back().score;
    }
    const float score = sum / static_cast<float>(layout_.points);
    if (score >= threshold_ && score > 0) add(points_, threshold_, score, 0);
    if (are_scores_of_classes(maps)) warn_once(scores_as_points());
    return take();
  }

 private:
  // Whether the maps have the sum 1 in each of some cells, as probabilities of classes do. Key
  // points may have a map of the background too, which is high in most cells.
  bool are_scores_of_classes(std::span<const float> maps) const {
    constexpr size_t kSamples = 64;
    const size_t cells = layout_.width * layout_.height;
    if (layout_.points < 2 || maps.size() < cells * layout_.points) return false;
    std::vector<size_t> high_cells(layout_.points);
    for (size_t i = 0; i < kSamples; ++i) {
      const size_t cell = i * (cells - 1) / (kSamples - 1);
      float sum = 0;
      for (size_t point = 0; point < layout_.points; ++point) {
        const float score = maps[point * layout_.next_point + cell * layout_.next_cell];
        sum += score;
        high_cells[point] += score > 0.5f;
      }
      if (!(std::abs(sum - 1) < 0.02f)) return false;
    }
    return *std::max_element(high_cells.begin(), high_cells.end()) <= kSamples / 2;
  }
  Error scores_as_points() const {
    return {.code = Code::SPEC_MISMATCH,
            .what = "the maps of key points look like scores of classes",
            .offered = std::to_string(layout_.points) + " maps whose sum is 1 in each cell",
            .needed = "maps that are near 0 away from their key point",
            .fix = "tensor_decoder mode=segmentation"};
  }
  // The first cell with the highest value; not-a-number never wins.
  size_t find_peak(const float* map) const noexcept {
    size_t best = 0;
    float max = -INFINITY;
    for (size_t cell = 0; cell < layout_.width * layout_.height; ++cell) {
      const float value = map[cell * layout_.next_cell];
      if (value > max) max = value, best = cell;
    }
    return best;
  }
  // 1, 0 or -1: which of the cells `next` before and after the peak is higher.
  float step(const float* map, size_t peak, size_t next) const noexcept {
    const float after = map[(peak + next) * layout_.next_cell];
    const float before = map[(peak - next) * layout_.next_cell];
    return static_cast<float>(after > before) - static_cast<float>(after < before);
  }

  Layout layout_;
  float threshold_;
  std::vector<results::KeyPoint> points_;
};

Match fit(const ModelSignature& model) {
  const auto layout = find_layout(model);
  if (!layout) return Match::No;
  // Maps of the input's own size are masks, scores of classes or depths; grids of larger cells are
  // those of detectors.
  constexpr size_t kMinCell = 2, kMaxCell = 8;
  const bool has_cells = model.input.width == 0 || (layout->width * kMinCell <= model.input.width &&
                                                    layout->width * kMaxCell >= model.input.width);
  if (!has_cells) return Match::No;
  // One map of this name is of what draws attention, or of text.
  const bool is_named =
      layout->points > 1 && (any_name_has(model, "heatmap") || any_name_has(model, "keypoint"));
  return is_named ? Match::Certain : Match::Possible;
}

std::unique_ptr<Head> open(const ModelSignature& model, const HeadOptions& options) {
  const auto layout = find_layout(model);
  if (!layout) throw wrong_outputs(model, kHeatMaps);
  return std::make_unique<HeatMaps>(*layout, options.threshold);
}

}  // namespace

size_t points_of_heat_maps(const ModelSignature& model) {
  return fit(model) == Match::No ? 0 : find_layout(model)->points;
}

bool is_usual_of_points(size_t maps) noexcept {
  constexpr size_t kUsual[] = {5,  14, 15, 16, 17, 18, 19,  20,  21,
                               25, 26, 29, 33, 68, 98, 106, 133, 136};
  return std::find(std::begin(kUsual), std::end(kUsual), maps) != std::end(kUsual);
}

const Family kMovenet{.name = "movenet",
                      .aliases = "movenet-lightning,movenet-thunder",
                      .tasks = kPose,
                      .outputs = "1 tensor 3:17",
                      .custom = "",
                      .threshold = 0.2f,
                      .fit = fit_movenet,
                      .open = open_movenet};

const Family kMovenetMultipose{.name = "movenet-multipose",
                               .aliases = "",
                               .tasks = kPose,
                               .outputs = "1 tensor 56:N, N persons",
                               .custom = "",
                               .threshold = 0.2f,
                               .fit = fit_multipose,
                               .open = open_multipose};

const Family kPosenet{.name = "posenet",
                      .aliases = "",
                      .tasks = kPose,
                      .outputs =
                          "tensors 17:W:H and 34:W:H; for several persons also 64:W:H, or "
                          "two 32:W:H",
                      .custom = "",
                      .threshold = 0.25f,
                      .fit = fit_posenet,
                      .open = open_posenet};

const Family kHeatMaps{.name = "heat-maps",
                       .aliases = "hrnet,simple-baselines",
                       .tasks = kPose,
                       .outputs =
                           "1 tensor W:H:POINTS or POINTS:W:H, W and H a whole fraction of "
                           "the input's",
                       .custom = "",
                       .threshold = 0.2f,
                       .fit = fit,
                       .open = open};

}  // namespace weir::heads
