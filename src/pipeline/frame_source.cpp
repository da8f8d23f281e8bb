// Pushes a program's tensors into an appsrc, caps before the first frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/frame_source.hpp"

#include <gst/video/video.h>

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
  caps_given_ = caps_ && gst_caps_get_size(caps_.get()) > 0;  // not ANY and not EMPTY
  spec_ = caps_given_ ? parse_tensors(caps_.get()) : FrameSpec{};
}

Status FrameSource::check_media(std::span<const weir_tensor> tensors) const {
  if (tensors.size() != 1 || tensors[0].info.type != WEIR_UINT8 || !tensors[0].data)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "a frame of media is one tensor of bytes",
                 .offered = std::to_string(tensors.size()) + " tensors",
                 .needed = "1 tensor: uint8"};
  GstVideoInfo video;
  if (!gst_structure_has_name(gst_caps_get_structure(caps_.get(), 0), "video/x-raw") ||
      !gst_video_info_from_caps(&video, caps_.get()) || tensors[0].bytes == video.size)
    return ok();
  return Error{.code = Code::FRAME_SIZE,
               .what = "a picture's size does not match the caps of the appsrc",
               .offered = std::to_string(tensors[0].bytes) + " bytes",
               .needed = std::to_string(video.size) +
                         " bytes: " + gst::UniqueText(gst_caps_to_string(caps_.get())).get()};
}

Status FrameSource::write_caps(const std::vector<TensorSpec>& specs) {
  FrameSpec spec{Format::Static, specs, Fraction{0, 1}};
  if (caps_ && spec == spec_) return ok();
  const auto caps = gst::Ref<GstCaps>::adopt(gst_caps_new_simple(
      "other/tensors", "format", G_TYPE_STRING, "static", "num_tensors", G_TYPE_INT,
      static_cast<gint>(specs.size()), "dimensions", G_TYPE_STRING, join_shapes(specs).c_str(),
      "types", G_TYPE_STRING, join_types(specs).c_str(), "framerate", GST_TYPE_FRACTION, 0, 1,
      nullptr));
  spec_ = std::move(spec);
  gst_app_src_set_caps(source_.get(), caps.get());
  caps_ = gst::Ref<GstCaps>::adopt(gst_app_src_get_caps(source_.get()));  // a copy
  return ok();
}

Status FrameSource::agree(std::span<const weir_tensor> tensors, std::vector<TensorSpec>* specs) {
  if (tensors.empty() || tensors.size() > kTensorLimit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a frame holds 1 to 256 tensors",
                 .offered = std::to_string(tensors.size()),
                 .needed = "1 to 256"};
  const bool fixed = caps_given_ && spec_.format == Format::Static;
  if (fixed && tensors.size() != spec_.tensors.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the caps of the appsrc have a different number of tensors",
                 .offered = std::to_string(tensors.size()),
                 .needed = spec_.to_string(),
                 .difference = "number of tensors"};
  for (size_t i = 0; i < tensors.size(); ++i) {
    auto spec = pushed_spec(tensors[i], fixed ? &spec_.tensors[i] : nullptr, i);
    if (!spec) return spec.error();
    specs->push_back(*std::move(spec));
  }
  return caps_given_ ? ok() : write_caps(*specs);
}

Status FrameSource::to_status(GstFlowReturn flow) const {
  if (flow == GST_FLOW_OK) return ok();
  if (flow != GST_FLOW_EOS) return not_started();
  return Error{.code = Code::CANCELLED,
               .what = "the stream has ended and accepts no more frames",
               .needed = "frames before end()"};
}

Status FrameSource::push(std::span<const weir_tensor> tensors, int64_t pts, int64_t duration) {
  std::unique_lock lock(mutex_);
  if (!started_) return not_started();
  read_caps();
  std::vector<TensorSpec> specs;
  const bool media = caps_given_ && spec_.format == Format::End;
  if (auto status = media ? check_media(tensors) : agree(tensors, &specs); !status) return status;
  if (media) specs.emplace_back();
  auto buffer = pushed_buffer(tensors, specs, media ? Format::Static : spec_.format);
  if (!buffer) return buffer.error();
  if (pts >= 0) GST_BUFFER_PTS(buffer->get()) = static_cast<GstClockTime>(pts);
  if (duration >= 0) GST_BUFFER_DURATION(buffer->get()) = static_cast<GstClockTime>(duration);
  const auto source = source_;
  if (caps_given_) lock.unlock();  // pushing may wait for room
  return to_status(gst_app_src_push_buffer(source.get(), buffer->release()));
}

void FrameSource::started() {
  std::lock_guard lock(mutex_);
  started_ = true;
}

void FrameSource::stopped() {
  std::lock_guard lock(mutex_);
  started_ = false;
  read_caps();
  if (caps_given_ || !caps_ || !is_replaceable_) return;
  caps_ = {};
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
