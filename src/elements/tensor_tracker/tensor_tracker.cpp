// tensor_tracker: numbers the objects of a stream of results, the same from frame to frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <sstream>
#include <utility>

#include "core/tensor/tensor_header.hpp"
#include "core/track/tracker.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/pads/timed_tensors.hpp"
#include "weir/results.hpp"

namespace weir {
namespace {
enum class TrackedClasses : int { Apart, Together };
}  // namespace
}  // namespace weir

namespace weir::gst {
template <>
struct EnumType<track::Mode> {
  static GType type() {
    static const GEnumValue values[] = {
        {0, "Prediction, and boxes of a low score continue tracks", "bytetrack"},
        {1, "Only the overlap with the last box", "iou"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirTrackerMode", values);
    return t;
  }
};
template <>
struct EnumType<TrackedClasses> {
  static GType type() {
    static const GEnumValue values[] = {{0, "An object keeps its class", "apart"},
                                        {1, "The class of an object may change", "together"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirTrackerClasses", values);
    return t;
  }
};
}  // namespace weir::gst

namespace weir {
namespace {

using gst::Ref;

Error without_rows(std::string offered, bool is_flexible) {
  return {.code = Code::SPEC_MISMATCH,
          .what = "tensor_tracker needs rows of results with boxes",
          .offered = std::move(offered),
          .needed = is_flexible
                        ? "a tensor whose entry in weir-columns has x1,y1,x2,y2; plain rows only "
                          "with format=static, where the caps have their length"
                        : "a tensor whose entry in weir-columns has x1,y1,x2,y2",
          .fix = is_flexible
                     ? "tensor_decoder mode=detection ! tensor_tracker, for a network's outputs; "
                       "other/tensors,format=static ! tensor_tracker, for plain rows"
                     : "tensor_decoder mode=detection ! tensor_tracker, for a network's outputs"};
}

// The columns of a stream of one tensor without weir-columns, as weir/detection.hpp defines them.
std::string plain_columns(const FrameSpec& spec) {
  if (spec.tensors.size() != 1 || spec.tensors[0].type != ElementType::Float32) return {};
  const auto length = spec.tensors[0].shape[0];
  if (length < 4 || length > WEIR_RESULTS_ROW_LIMIT || (length > 6 && length % 2 != 0)) return {};
  std::string columns = "x1,y1,x2,y2";
  if (length > 4) columns += ",score";
  if (length > 5) columns += ",class";
  if (length > 6) columns += ",xy:" + std::to_string((length - 6) / 2);
  return columns;
}

class TensorTracker : public gst::CountedTransform<TensorTracker> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorTracker", "tensor_tracker", "TensorTracker", "Filter/Tensor",
      "Gives each object a number that stays the same from frame to frame"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS(
                                  "static") "; " WEIR_CAPS_TENSORS("flexible"))),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("flexible"))),
  };
  struct Settings {
    track::Mode mode = track::Mode::ByteTrack;
    TrackedClasses classes = TrackedClasses::Apart;
    float high = 0.5f, low = 0.1f, match = 0.2f;
    uint64_t max_age = 1000000000;
    uint32_t min_hits = 2;
    bool camera_motion = true;
    int32_t embeddings = -1;
    float appearance = 0.25f;
  };
  static constexpr auto kPlaying = gst::Changeable::WhilePlaying;
  static constexpr uint64_t kMax = uint64_t{24} * 3600 * 1000000000;
  static constexpr std::tuple kProperties{
      gst::Property{"mode", &Settings::mode, "How boxes are matched with tracks", kPlaying},
      gst::Property{"classes", &Settings::classes, "Whether an object keeps its class", kPlaying},
      gst::Property{"high", &Settings::high,
                    "Minimum score of boxes that are matched first and that begin tracks", kPlaying,
                    0.0f, 1.0f},
      gst::Property{"low", &Settings::low, "Minimum score of boxes that continue tracks", kPlaying,
                    0.0f, 1.0f},
      gst::Property{"match", &Settings::match,
                    "Minimum intersection over union of a track and its box", kPlaying, 0.0f, 1.0f},
      gst::Property{"max-age", &Settings::max_age,
                    "Time in nanoseconds after which a track without a box is deleted", kPlaying,
                    uint64_t{0}, kMax},
      gst::Property{"min-hits", &Settings::min_hits,
                    "Number of consecutive frames with a box before an object gets its number",
                    kPlaying, 1u, 1000u},
      gst::Property{
          "camera-motion", &Settings::camera_motion,
          "Compensate for motion that most objects have in common, which is that of the camera",
          kPlaying},
      gst::Property{
          "embeddings", &Settings::embeddings,
          "Index of the tensor with a vector for each row of the first tensor of rows; -1 = none",
          kPlaying, -1, int{kTensorLimit} - 1},
      gst::Property{"appearance", &Settings::appearance,
                    "Maximum cosine distance of a track and the vector of its box", kPlaying, 0.0f,
                    2.0f},
  };

  Status start() {
    if (auto status = check(settings()); !status) return status;
    ledger_.reset();
    tracker_ = {};
    time_ = 0;
    tracks_ = given_ = 0;
    has_warned_ = false;
    return ok();
  }

  GstCaps* transform_caps(GstPadDirection direction, GstCaps* caps, GstCaps* filter) {
    return caps_of_other_pad(direction, filter, [&] { return output_caps(caps); });
  }

  Status set_caps(GstCaps* in, GstCaps*) {
    auto spec = gst::fixed_spec_from_caps(in);
    if (!spec) return spec.error();
    columns_.clear();
    const std::string text = columns_text(output_roles(in, &columns_));
    const auto has_box = [](const auto& c) { return c.kind == WEIR_RESULT_ROWS && c.box >= 0; };
    if (std::none_of(columns_.begin(), columns_.end(), has_box))
      return without_rows(text.empty() ? spec->to_string() : "weir-columns=" + text,
                          text.empty() && spec->format == Format::Flexible);
    input_ = *std::move(spec);
    return ok();
  }

  GstFlowReturn prepare_output_buffer(GstBuffer* in, GstBuffer** out) {
    *out = gst::buffer_like(in).release();
    return GST_FLOW_OK;
  }

  GstFlowReturn transform(GstBuffer* in, GstBuffer* out) {
    const Status status = convert(in, out);
    reader_.clear();
    if (!status) return failed(status.error());
    ledger_.consumed_and_pushed();
    return GST_FLOW_OK;
  }

  void add_stats(GstStructure* stats) const {
    gst_structure_set(stats, "tracks", G_TYPE_UINT64, tracks_.load(), "numbers-given",
                      G_TYPE_UINT64, given_.load(), nullptr);
  }

  Settings settings_;

 private:
  static Status check(const Settings& s) {
    if (s.low <= s.high) return ok();
    const auto short_number = [](float number) {
      std::ostringstream text;
      text << number;
      return text.str();
    };
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "no box can have a score of at least low and less than high",
        .offered = "low=" + short_number(s.low) + " high=" + short_number(s.high),
        .needed = "a value of low that is at most high",
        .fix = "tensor_tracker low=" + short_number(s.high) + " high=" + short_number(s.low)};
  }

  // Where the number of a box is written.
  struct Place {
    size_t tensor, index;
  };

  // The roles of the output; `columns` (may be null) gets those of the input.
  static ResultRoles output_roles(const GstCaps* in, std::vector<weir_result_columns>* columns) {
    auto roles = gst::roles_from_caps(in);
    if (const auto spec = gst::spec_from_caps(in); roles.empty() && spec)
      if (const auto plain = plain_columns(*spec); !plain.empty()) roles = {{plain, ""}};
    for (auto& role : roles) {
      const auto parsed = result_columns(role.columns, 0).value_or(weir_result_columns{});
      if (columns) columns->push_back(parsed);
      if (parsed.kind == WEIR_RESULT_ROWS && parsed.box >= 0 && parsed.track < 0)
        role.columns += ",track";
    }
    return roles;
  }
  Ref<GstCaps> output_caps(const GstCaps* in) const {
    if (!gst_caps_is_fixed(in))
      return Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(GST_BASE_TRANSFORM_SRC_PAD(self())));
    auto caps = Ref<GstCaps>::adopt(
        gst_caps_new_simple("other/tensors", "format", G_TYPE_STRING, "flexible", nullptr));
    if (const auto* rate = gst_structure_get_value(gst_caps_get_structure(in, 0), "framerate"))
      gst_caps_set_value(caps.get(), "framerate", rate);
    return gst::with_roles(std::move(caps), output_roles(in, nullptr));
  }

  void warn_of_left_out() {
    if (std::exchange(has_warned_, true)) return;
    constexpr size_t kLimit = track::Tracker::kBoxLimit;
    gst::post_warning(element(),
                      {.code = Code::LIMIT_EXCEEDED,
                       .what = "a frame has more boxes than tensor_tracker follows; those of the "
                               "lowest scores get no number",
                       .offered = std::to_string(tracker_.left_out() + kLimit) + " boxes",
                       .needed = "at most " + std::to_string(kLimit),
                       .fix = "tensor_tracker low=0.5 ignores boxes with lower scores"});
  }

  // The running time of the frame in seconds; without timestamp or a segment in time, that of the
  // frame rate (30 frames per second if there is none) after the last frame.
  double get_time(GstBuffer* in) const {
    const auto running = gst::running_time(self()->segment, GST_BUFFER_PTS(in));
    if (GST_CLOCK_TIME_IS_VALID(running)) return static_cast<double>(running) / GST_SECOND;
    const bool has_rate = input_.rate.valid() && input_.rate.numerator > 0;
    return time_ + (has_rate ? double(input_.rate.denominator) / input_.rate.numerator : 1.0 / 30);
  }

  Status convert(GstBuffer* in, GstBuffer* out) {
    if (auto status = reader_.read(in, input_); !status) return status;
    ledger_.copied(reader_.bytes_copied());
    const auto& tensors = reader_.tensors();
    std::vector<gst::TensorPiece> pieces;
    if (auto status = gst::append_pieces(in, reader_, &ledger_, &pieces); !status) return status;
    boxes_.clear();
    places_.clear();
    rows_.resize(tensors.size());
    const Settings s = settings();
    if (auto status = check(s); !status) return status;
    for (size_t i = 0; i < tensors.size(); ++i)
      if (auto status = read_rows(i, s.classes); !status) return status;
    if (s.embeddings >= 0 && !tensors.empty())
      if (auto status = read_embeddings(static_cast<size_t>(s.embeddings)); !status) return status;
    time_ = get_time(in);
    const auto& numbers = tracker_.follow(boxes_, time_,
                                          {.mode = s.mode,
                                           .high = s.high,
                                           .low = s.low,
                                           .match = s.match,
                                           .max_age = static_cast<double>(s.max_age) / GST_SECOND,
                                           .camera_motion = s.camera_motion,
                                           .appearance = s.appearance,
                                           .min_hits = s.min_hits});
    for (size_t i = 0; i < numbers.size(); ++i)
      rows_[places_[i].tensor][places_[i].index] = static_cast<float>(numbers[i]);
    if (tracker_.left_out() > 0) warn_of_left_out();
    tracks_ = tracker_.tracks();
    given_ = tracker_.numbers_given();
    return append(&pieces, out);
  }

  bool is_tracked(size_t tensor) const {
    return tensor < columns_.size() && columns_[tensor].kind == WEIR_RESULT_ROWS &&
           columns_[tensor].box >= 0;
  }

  // Copies the rows of a tensor, with a column for the track, and collects their boxes.
  Status read_rows(size_t tensor, TrackedClasses classes) {
    rows_[tensor].clear();
    if (!is_tracked(tensor)) return ok();
    const auto& columns = columns_[tensor];
    const gst::TensorPlace& view = reader_.tensors()[tensor];
    if (view.spec.type != ElementType::Float32 || view.spec.shape[0] != columns.length)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "tensor " + std::to_string(tensor) + " does not match weir-columns",
                   .offered = view.spec.to_string(),
                   .needed = "float32 " + std::to_string(columns.length) + ":N",
                   .fix = "correct weir-columns or the tensor in the upstream element"};
    const size_t length = columns.length, wider = length + (columns.track < 0);
    const size_t track = columns.track < 0 ? length : static_cast<size_t>(columns.track);
    const size_t n = view.payload.size() / (length * sizeof(float));
    rows_[tensor].resize(n * wider);
    for (size_t i = 0; i < n; ++i) {
      float* const numbers = rows_[tensor].data() + i * wider;
      std::memcpy(numbers, view.payload.data() + i * length * sizeof(float),
                  length * sizeof(float));
      const ResultRow row(columns, numbers);
      if (row.is_background() || row.parent() >= 0) continue;
      const int64_t group =
          static_cast<int64_t>(tensor) << 32 |
          (classes == TrackedClasses::Apart ? static_cast<uint32_t>(row.class_index()) : 0u);
      boxes_.push_back({row.box(), row.score(), group});
      places_.push_back({tensor, i * wider + track});
    }
    return ok();
  }

  // Gives each box of the first tensor of rows its vector. Vectors are aligned as floats, or
  // copied.
  Status read_embeddings(size_t tensor) {
    size_t of = 0;
    while (of < columns_.size() && !is_tracked(of)) ++of;
    if (tensor >= reader_.tensors().size())
      return bad_embeddings(tensor, std::to_string(reader_.tensors().size()) + " tensors", of);
    const gst::TensorPlace& view = reader_.tensors()[tensor];
    const size_t length = view.spec.shape[0];
    const size_t rows = of < rows_.size() ? rows_[of].size() / row_length(of) : 0;
    if (tensor == of || view.spec.type != ElementType::Float32 || length == 0 ||
        view.payload.size() != rows * length * sizeof(float))
      return bad_embeddings(tensor,
                            view.spec.to_string() + " for " + std::to_string(rows) + " rows", of);
    vectors_.resize(rows * length);
    std::memcpy(vectors_.data(), view.payload.data(), view.payload.size());
    for (size_t i = 0; i < boxes_.size(); ++i)
      if (places_[i].tensor == of)
        boxes_[i].appearance =
            std::span(vectors_).subspan(places_[i].index / row_length(of) * length, length);
    return ok();
  }
  static Error bad_embeddings(size_t tensor, std::string offered, size_t of) {
    return {.code = Code::SPEC_MISMATCH,
            .what = "tensor " + std::to_string(tensor) + " is not a vector for each row",
            .offered = std::move(offered),
            .needed = "float32 L:N, a vector of L numbers for each of the N rows of tensor " +
                      std::to_string(of),
            .fix =
                "embeddings=NUMBER of the tensor with the vectors, which tensor_mux appends to "
                "the rows; embeddings=-1 tracks objects without vectors"};
  }
  size_t row_length(size_t tensor) const {
    return columns_[tensor].length + (columns_[tensor].track < 0);
  }

  // Rows as they were read, with their numbers; other tensors by reference where they have a
  // header.
  Status append(std::vector<gst::TensorPiece>* pieces, GstBuffer* out) {
    for (size_t i = 0; i < pieces->size(); ++i) {
      if (!is_tracked(i) && input_.format == Format::Flexible) continue;
      auto piece = is_tracked(i) ? piece_of_rows(i) : gst::with_header((*pieces)[i], &ledger_);
      if (!piece) return piece.error();
      (*pieces)[i] = *std::move(piece);
    }
    return gst::append_tensors(*pieces, out, &ledger_);
  }

  Result<gst::TensorPiece> piece_of_rows(size_t tensor) {
    TensorHeader header{.spec = reader_.tensors()[tensor].spec, .format = Format::Flexible};
    if (columns_[tensor].track < 0) header.spec.shape = widened(header.spec.shape);
    const auto numbers = std::as_bytes(std::span(rows_[tensor]));
    ledger_.copied(numbers.size());
    return gst::make_piece(header, numbers);
  }
  static Shape widened(Shape shape) {
    shape[0] += 1;
    return shape;
  }

  // Streaming thread:
  std::vector<weir_result_columns> columns_;  // of the input
  FrameSpec input_;
  gst::FrameLayout reader_;
  track::Tracker tracker_;
  double time_ = 0;
  bool has_warned_ = false;
  std::vector<std::vector<float>> rows_;  // of each tensor; kept for their memory
  std::vector<float> vectors_;
  std::vector<track::Observation> boxes_;
  std::vector<Place> places_;
  std::atomic<uint64_t> tracks_{0}, given_{0};
};

}  // namespace

bool register_tensor_tracker(GstPlugin* plugin) {
  return TensorTracker::register_in(plugin);
}

}  // namespace weir
