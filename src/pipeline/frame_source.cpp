// Pushes a program's tensors into an appsrc, caps before the first frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/frame_source.hpp"

#include <gst/video/video.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "pipeline/pushed_buffer.hpp"

namespace weir::pipeline {
namespace {

FrameSpec parse_tensors(const GstCaps* caps) {
  const auto spec = gst::fixed_spec_from_caps(caps);
  return spec ? *spec : FrameSpec{};
}

// Copies the properties that the text or the program set to another appsrc.
void copy_properties(GObject* from, GObject* to) {
  guint count = 0;
  const gst::Unique<GParamSpec*, g_free> all(
      g_object_class_list_properties(G_OBJECT_GET_CLASS(from), &count));
  for (guint i = 0; i < count; ++i) {
    const GParamSpec* spec = all.get()[i];
    const std::string_view name = spec->name;
    if ((spec->flags & G_PARAM_READWRITE) != G_PARAM_READWRITE ||
        (spec->flags & G_PARAM_CONSTRUCT_ONLY) || name == "name" || name == "parent" ||
        name == "caps")
      continue;
    GValue value = G_VALUE_INIT;
    g_value_init(&value, spec->value_type);
    g_object_get_property(from, spec->name, &value);
    g_object_set_property(to, spec->name, &value);
    g_value_unset(&value);
  }
}

// Replaces a stopped appsrc by a new one with the same name and properties.
gst::Ref<GstAppSrc> replace(GstAppSrc* old) {
  const auto bin = gst::Ref<GstObject>::adopt(gst_object_get_parent(GST_OBJECT(old)));
  const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(GST_ELEMENT(old), "src"));
  const auto peer = gst::Ref<GstPad>::adopt(gst_pad_get_peer(pad.get()));
  const gst::UniqueText name(gst_object_get_name(GST_OBJECT(old)));
  GstElement* made = gst_element_factory_make("appsrc", nullptr);
  copy_properties(G_OBJECT(old), G_OBJECT(made));
  if (peer) gst_pad_unlink(pad.get(), peer.get());
  gst_bin_remove(GST_BIN(bin.get()), GST_ELEMENT(old));
  gst_object_set_name(GST_OBJECT(made), name.get());
  gst_bin_add(GST_BIN(bin.get()), made);
  const auto source = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(made, "src"));
  if (peer) gst_pad_link(source.get(), peer.get());
  return gst::Ref<GstAppSrc>::share(GST_APP_SRC(made));
}

gst::Ref<GstCaps> caps_after(GstAppSrc* source) {
  const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(GST_ELEMENT(source), "src"));
  return gst::Ref<GstCaps>::adopt(gst_pad_peer_query_caps(pad.get(), nullptr));
}

bool is_tensor_stream(const GstStructure* structure) {
  return g_str_has_prefix(gst_structure_get_name(structure), "other/tensor");
}

// The only caps that an element accepts, as a capsfilter, with 0/1 where it accepts any frame rate.
// Null if it leaves another choice.
gst::Ref<GstCaps> only_caps(const GstCaps* accepted) {
  if (gst_caps_get_size(accepted) != 1) return {};
  auto out = gst::Ref<GstCaps>::adopt(gst_caps_copy(accepted));
  GstStructure* const only = gst_caps_get_structure(out.get(), 0);
  const bool is_tensors = is_tensor_stream(only);
  if (gst_structure_has_field(only, "framerate"))
    gst_structure_fixate_field_nearest_fraction(only, "framerate", 0, 1);
  else if (is_tensors)
    gst_structure_set(only, "framerate", GST_TYPE_FRACTION, 0, 1, nullptr);
  const bool is_complete = !is_tensors || parse_tensors(out.get()).format != Format::End;
  return gst_caps_is_fixed(out.get()) && is_complete ? std::move(out) : gst::Ref<GstCaps>();
}

// `is_single`: as other/tensor, which has one.
GstStructure* static_structure(const std::vector<TensorSpec>& specs, bool is_single) {
  const std::string shapes = join_shapes(specs), types = join_types(specs);
  if (is_single)
    return gst_structure_new("other/tensor", "dimension", G_TYPE_STRING, shapes.c_str(), "type",
                             G_TYPE_STRING, types.c_str(), nullptr);
  return gst_structure_new("other/tensors", "format", G_TYPE_STRING, "static", "num_tensors",
                           G_TYPE_INT, static_cast<gint>(specs.size()), "dimensions", G_TYPE_STRING,
                           shapes.c_str(), "types", G_TYPE_STRING, types.c_str(), nullptr);
}

bool is_empty(const weir_tensor& tensor) {
  const auto& info = tensor.info;
  return info.rank <= WEIR_RANK_LIMIT &&
         std::find(info.shape, info.shape + info.rank, 0) != info.shape + info.rank;
}

// Caps of the tensors, with the name, the format and the frame rate that the next element insists
// on; flexible for tensors without elements.
gst::Ref<GstCaps> tensor_caps(const std::vector<TensorSpec>& specs, const GstCaps* accepted) {
  bool is_flexible = true, is_single = specs.size() == 1;
  const bool has_empty = std::any_of(specs.begin(), specs.end(),
                                     [](const auto& spec) { return spec.shape.is_empty(); });
  gst::Ref<GstCaps> rated;  // the first structure of tensors
  for (guint i = 0; i < gst_caps_get_size(accepted); ++i) {
    const GstStructure* structure = gst_caps_get_structure(accepted, i);
    if (!is_tensor_stream(structure)) continue;
    is_flexible &= g_strcmp0(gst_structure_get_string(structure, "format"), "flexible") == 0;
    is_single &= gst_structure_has_name(structure, "other/tensor") != FALSE;
    if (!rated) rated = gst::Ref<GstCaps>::adopt(gst_caps_copy_nth(accepted, i));
  }
  GstStructure* const out =
      (rated && is_flexible) || has_empty
          ? gst_structure_new("other/tensors", "format", G_TYPE_STRING, "flexible", nullptr)
          : static_structure(specs, rated && is_single);
  gst_structure_set(out, "framerate", GST_TYPE_FRACTION, 0, 1, nullptr);
  if (rated) {
    GstStructure* const first = gst_caps_get_structure(rated.get(), 0);
    if (gst_structure_has_field(first, "framerate"))
      gst_structure_fixate_field_nearest_fraction(first, "framerate", 0, 1);
    const GValue* rate = gst_structure_get_value(first, "framerate");
    if (rate && gst_value_is_fixed(rate)) gst_structure_set_value(out, "framerate", rate);
  }
  auto caps = gst::Ref<GstCaps>::adopt(gst_caps_new_empty());
  gst_caps_append_structure(caps.get(), out);
  return caps;
}

size_t count_bytes(std::span<const weir_tensor> tensors) {
  return std::accumulate(tensors.begin(), tensors.end(), size_t{0},
                         [](size_t sum, const weir_tensor& tensor) { return sum + tensor.bytes; });
}

std::vector<std::byte> join_bytes(std::span<const weir_tensor> tensors) {
  std::vector<std::byte> out;
  out.reserve(count_bytes(tensors));
  for (const auto& tensor : tensors) {
    const auto* const first = static_cast<const std::byte*>(tensor.data);
    out.insert(out.end(), first, first + tensor.bytes);
  }
  return out;
}

}  // namespace

Error not_started() {
  return Error{.code = Code::CANCELLED,
               .what = "the pipeline is stopped and processes no frames",
               .needed = "a pipeline in PLAYING or PAUSED",
               .fix = "pipeline.start()"};
}

FrameSource::FrameSource(GstAppSrc* source, bool is_replaceable)
    : is_replaceable_(is_replaceable), source_(gst::Ref<GstAppSrc>::share(source)) {
  g_object_set(source, "format", GST_FORMAT_TIME, nullptr);
  read_caps();
}

void FrameSource::read_caps() {
  auto caps = gst::Ref<GstCaps>::adopt(gst_app_src_get_caps(source_.get()));
  if (caps.get() == caps_.get()) return;
  caps_ = std::move(caps);
  is_set_ = false;
  is_fixed_ = caps_ && gst_caps_get_size(caps_.get()) > 0;  // not ANY and not EMPTY
  spec_ = is_fixed_ ? parse_tensors(caps_.get()) : FrameSpec{};
}

void FrameSource::take_caps_of_next() {
  if (is_fixed_ || asked_next_) return;
  asked_next_ = true;
  const auto only = only_caps(caps_after(source_.get()).get());
  if (!only) return;
  set_caps(only.get());
  is_fixed_ = true;
}

void FrameSource::set_caps(GstCaps* caps) {
  spec_ = parse_tensors(caps);
  gst_app_src_set_caps(source_.get(), caps);
  caps_ = gst::Ref<GstCaps>::adopt(gst_app_src_get_caps(source_.get()));  // a copy
  is_set_ = true;
}

Result<gst::Ref<GstBuffer>> FrameSource::media_buffer(std::span<const weir_tensor> tensors) const {
  for (const auto& tensor : tensors)
    if (!tensor.data && tensor.bytes > 0)
      return Error{.code = Code::FRAME_SIZE, .what = "a tensor has no memory"};
  GstVideoInfo video;
  const size_t bytes = count_bytes(tensors);
  if (gst_structure_has_name(gst_caps_get_structure(caps_.get(), 0), "video/x-raw") &&
      gst_video_info_from_caps(&video, caps_.get()) && bytes != video.size) {
    const size_t packed = picture_bytes_without_padding(video);
    if (bytes == packed) return padded_picture(join_bytes(tensors).data(), video);
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a picture's size does not match the caps of the appsrc",
                 .offered = std::to_string(bytes) + " bytes",
                 .needed = std::to_string(packed > 0 ? packed : video.size) +
                           " bytes: " + gst::UniqueText(gst_caps_to_string(caps_.get())).get()};
  }
  if (tensors.size() <= kMemoryLimit)
    return pushed_buffer(tensors, std::vector<TensorSpec>(tensors.size()), Format::Static);
  std::vector<std::byte> joined = join_bytes(tensors);
  weir_tensor one{};
  one.data = joined.data();
  one.bytes = joined.size();
  return pushed_buffer({&one, 1}, std::vector<TensorSpec>(1), Format::Static);
}

Status FrameSource::write_caps(const std::vector<TensorSpec>& specs) {
  const bool is_unchanged =
      spec_.format == Format::Flexible || spec_ == FrameSpec{Format::Static, specs, spec_.rate};
  if (caps_ && is_unchanged) return ok();
  if (is_pushing_)
    return Error{.code = Code::CANCELLED,
                 .what = "a push on this thread waits for a callback, which cannot change the caps",
                 .offered = FrameSpec{Format::Static, specs, spec_.rate}.to_string(),
                 .needed = spec_.to_string(),
                 .fix = "push the frame when the callback has returned"};
  set_caps(tensor_caps(specs, caps_after(source_.get()).get()).get());
  return ok();
}

Result<TensorSpec> FrameSource::find_spec(const weir_tensor& tensor, const TensorSpec* expected,
                                          size_t index) const {
  // Types are not compared with the caps of a capsfilter, as in NNStreamer.
  if (expected && is_set_ && tensor.data && tensor.bytes == expected->bytes()) return *expected;
  return pushed_spec(tensor, expected, index);
}

Result<gst::Ref<GstBuffer>> FrameSource::tensor_buffer(std::span<const weir_tensor> tensors) {
  if (tensors.empty() || tensors.size() > kTensorLimit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a frame holds 1 to 256 tensors",
                 .offered = std::to_string(tensors.size()),
                 .needed = "1 to 256"};
  const bool fixed = is_fixed_ && spec_.format == Format::Static;
  if (fixed && tensors.size() != spec_.tensors.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the caps of the appsrc have a different number of tensors",
                 .offered = std::to_string(tensors.size()),
                 .needed = spec_.to_string(),
                 .difference = "number of tensors"};
  std::vector<TensorSpec> specs;
  for (size_t i = 0; i < tensors.size(); ++i) {
    auto spec = find_spec(tensors[i], fixed ? &spec_.tensors[i] : nullptr, i);
    if (!spec) return spec.error();
    specs.push_back(*std::move(spec));
  }
  if (!is_fixed_)
    if (auto status = write_caps(specs); !status) return status.error();
  return pushed_buffer(tensors, specs, spec_.format);
}

Status FrameSource::to_status(GstFlowReturn flow) const {
  if (flow == GST_FLOW_OK) return ok();
  if (flow != GST_FLOW_EOS) return not_started();
  return Error{.code = Code::CANCELLED,
               .what = "the stream has ended and accepts no more frames",
               .needed = "frames before end()"};
}

Result<gst::Ref<GstBuffer>> FrameSource::make_buffer(std::span<const weir_tensor> tensors) {
  const bool is_media = is_fixed_ && spec_.format == Format::End;
  return is_media ? media_buffer(tensors) : tensor_buffer(tensors);
}

Status FrameSource::push(std::span<const weir_tensor> tensors, int64_t pts, int64_t duration) {
  std::unique_lock order(order_);
  std::unique_lock lock(mutex_);
  if (!started_) return not_started();
  read_caps();
  take_caps_of_next();
  if (std::any_of(tensors.begin(), tensors.end(), is_empty) && !may_be_flexible())
    return push_gap(tensors, pts, duration);
  auto buffer = make_buffer(tensors);
  if (!buffer && is_set_ && is_fixed_) {  // the next element may accept other caps by now
    is_fixed_ = asked_next_ = false;
    take_caps_of_next();
    buffer = make_buffer(tensors);
  }
  if (!buffer) return buffer.error();
  if (pts >= 0) GST_BUFFER_PTS(buffer->get()) = static_cast<GstClockTime>(pts);
  if (duration >= 0) GST_BUFFER_DURATION(buffer->get()) = static_cast<GstClockTime>(duration);
  const auto source = source_;
  if (is_fixed_) order.unlock();
  const bool is_outermost = order && !std::exchange(is_pushing_, true);
  lock.unlock();
  // Waits for room, and calls functions of the program for "enough-data".
  const auto flow = gst_app_src_push_buffer(source.get(), buffer->release());
  if (is_outermost) {
    lock.lock();
    is_pushing_ = false;
  }
  return to_status(flow);
}

bool FrameSource::may_be_flexible() const {
  if (is_fixed_ || spec_.format == Format::Flexible) return spec_.format == Format::Flexible;
  const auto flexible = gst::Ref<GstCaps>::adopt(
      gst_caps_new_simple("other/tensors", "format", G_TYPE_STRING, "flexible", nullptr));
  return gst_caps_can_intersect(caps_after(source_.get()).get(), flexible.get());
}

// Static tensors and media without elements cannot be: downstream learns that their time has
// passed.
Status FrameSource::push_gap(std::span<const weir_tensor> tensors, int64_t pts,
                             int64_t duration) const {
  for (size_t i = 0; i < tensors.size(); ++i)
    if (is_empty(tensors[i]))
      if (auto spec = pushed_spec(tensors[i], nullptr, i); !spec) return spec.error();
  if (pts < 0) return ok();
  const GstClockTime length =
      duration < 0 ? GST_CLOCK_TIME_NONE : static_cast<GstClockTime>(duration);
  gst_element_send_event(GST_ELEMENT(source_.get()),
                         gst_event_new_gap(static_cast<GstClockTime>(pts), length));
  return ok();
}

std::vector<TensorSpec> FrameSource::tensors() {
  std::lock_guard lock(mutex_);
  read_caps();
  take_caps_of_next();
  return is_fixed_ && spec_.format == Format::Static ? spec_.tensors : std::vector<TensorSpec>();
}

void FrameSource::started() {
  std::lock_guard lock(mutex_);
  started_ = true;
  asked_next_ = false;
}

void FrameSource::stopped() {
  std::lock_guard lock(mutex_);
  started_ = false;
  read_caps();
  if (!is_set_) return;
  is_fixed_ = false;
  if (!is_replaceable_) return;
  caps_ = {};
  is_set_ = false;
  source_ = replace(source_.get());
}

gst::Ref<GstAppSrc> FrameSource::source() const {
  std::lock_guard lock(mutex_);
  return source_;
}

Status FrameSource::end() {
  return to_status(gst_app_src_end_of_stream(source().get()));
}

}  // namespace weir::pipeline
