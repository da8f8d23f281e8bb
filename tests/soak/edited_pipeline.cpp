// Builds the pipeline, edits it, and checks what must hold afterwards.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edited_pipeline.hpp"

#include "gstcpp/pads/output_selector.hpp"

namespace weir::soak {
namespace {

constexpr size_t kMaxBranches = 6, kMaxRequestPads = 3;
constexpr GstClockTime kPatienceOfGst = std::chrono::nanoseconds(kPatience).count();
// Pixels of 4 bytes, `width` of them in a row. The lower part switches: its frames arrive on one of
// two paths, or not at all, and leave on one of two paths. The branches of join have the same caps:
// flexible ones, which stay when the width changes.
constexpr char kLaunch[] =
    "appsrc name=feed format=time ! tensor_converter ! tee name=t allow-not-linked=true "
    "t. ! queue ! tensor_transform mode=arithmetic option=add:1 ! in.sink_0 "
    "t. ! queue ! in.sink_1 "
    "input-selector name=in sync-streams=false ! valve name=valve drop-mode=forward-sticky-events "
    "! "
    "output-selector name=out "
    "out.src_0 ! tensor_sink async=false out.src_1 ! queue ! tensor_sink async=false "
    "t. ! queue ! tensor_transform mode=typecast option=uint8 ! other/tensors,format=flexible ! "
    "tee name=s s. ! queue ! join.sink_0 join name=join ! tensor_converter ! "
    "tensor_sink name=joined async=false "
    "t. ! queue ! mux.sink_0 tensor_mux name=mux sync-mode=slowest ! "
    "tensor_sink name=muxed async=false";
// Frames with the same time are paired, so every byte is the number of one frame.
const Line kMuxed{"", 0, false, false};

// The caps between decoder and converter keep the stream static: otherwise the decoder offers
// flexible tensors first, which the converter also accepts.
std::vector<Line> lines_with(const std::string& model) {
  const std::string cast = "queue ! tensor_transform mode=typecast option=float32 ! ",
                    end = " ! tensor_sink name=end";
  return {
      {"queue" + end, 0, false, true},
      {"queue ! tensor_transform mode=arithmetic option=add:2" + end, 2, false, true},
      {cast +
           "tensor_transform mode=arithmetic option=add:3 ! "
           "tensor_transform mode=clamp option=0:300" +
           end,
       3, true, true},
      {cast + "tensor_filter framework=fake model=" + model + end, 1, true, true},
      {"queue ! tensor_decoder mode=direct_video ! video/x-raw ! tensor_converter" + end, 0, false,
       true},
      {"queue ! tensor_transform mode=arithmetic option=add:1 ! queue max-size-buffers=1 ! "
       "tensor_decoder mode=direct_video ! video/x-raw ! tensor_converter ! queue" +
           end,
       1, false, true},
      {"queue ! tee name=b b. ! queue ! m.sink_0 b. ! queue ! m.sink_1 "
       "tensor_mux name=m sync-mode=nosync" +
           end,
       0, false, true},
  };
}

}  // namespace

EditedPipeline::EditedPipeline(uint32_t seed, const std::string& model)
    : seed_(seed),
      random_(seed),
      lines_(lines_with(model)),
      muxed_(kMuxed),
      joined_(kMuxed),
      pipeline_(Ref<GstElement>::adopt(
          GST_ELEMENT(gst_object_ref_sink(gst_parse_launch(kLaunch, nullptr))))),
      tee_(Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "t"))) {
  const auto source = find("feed");
  GstAppSrcCallbacks callbacks{};
  callbacks.need_data = feed;
  gst_app_src_set_callbacks(GST_APP_SRC(source.get()), &callbacks, this, nullptr);
  always_ = std::make_unique<Branch>(tee_.get(), lines_[0]);
  mux_pads_ = std::make_unique<RequestPads>(tee_.get(), find("mux").get());
  join_pads_ = std::make_unique<RequestPads>(find("s").get(), find("join").get());
  watch("muxed", &muxed_);
  watch("joined", &joined_);
  gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
}

EditedPipeline::~EditedPipeline() {
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
}

Ref<GstElement> EditedPipeline::find(const char* name) const {
  return Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), name));
}

void EditedPipeline::watch(const char* sink, Arrivals* arrivals) {
  g_signal_connect(find(sink).get(), "new-data",
                   G_CALLBACK(+[](GstElement*, GstBuffer* b, Arrivals* a) { a->arrived(b); }),
                   arrivals);
}

// Runs on the streaming thread of the source, which requests the next frame.
void EditedPipeline::feed(GstAppSrc* source, guint, gpointer data) {
  auto* self = static_cast<EditedPipeline*>(data);
  if (self->over_) {
    gst_app_src_end_of_stream(source);
    return;
  }
  const int width = self->width_;
  const uint64_t number = self->fed_++;
  const auto buffer = Ref<GstBuffer>::adopt(
      gst_buffer_new_allocate(nullptr, static_cast<gsize>(width) * 4, nullptr));
  gst_buffer_memset(buffer.get(), 0, static_cast<guint8>(number % kNumbers),
                    static_cast<gsize>(width) * 4);
  GST_BUFFER_PTS(buffer.get()) = number * GST_MSECOND;
  const auto caps = Ref<GstCaps>::adopt(gst_caps_new_simple(
      "video/x-raw", "format", G_TYPE_STRING, "RGBA", "width", G_TYPE_INT, width, "height",
      G_TYPE_INT, 1, "framerate", GST_TYPE_FRACTION, 1000, 1, nullptr));
  const gst::Unique<GstSample, gst_sample_unref> sample(
      gst_sample_new(buffer.get(), caps.get(), nullptr, nullptr));
  gst_app_src_push_sample(source, sample.get());
}

void EditedPipeline::add_branch() {
  if (branches_.size() >= kMaxBranches) return;
  const auto& line = lines_[static_cast<size_t>(any(static_cast<int>(lines_.size())))];
  branches_.push_back(std::make_unique<Branch>(tee_.get(), line));
}

std::string EditedPipeline::remove_branch(Removal removal) {
  if (branches_.empty()) return "";
  const auto at = branches_.begin() + any(static_cast<int>(branches_.size()));
  const auto branch = std::move(*at);
  branches_.erase(at);
  const std::string wrong = branch->remove(removal);
  if (removal == Removal::Drained && wrong.find("EOS") == std::string::npos)
    lost_ += branch->arrivals().entries() - branch->arrivals().frames();
  return wrong;
}

Ref<GstPad> EditedPipeline::pad(const char* element, const char* name) const {
  return Ref<GstPad>::adopt(gst_element_get_static_pad(find(element).get(), name));
}

std::string EditedPipeline::pause() {
  for (const GstState state : {GST_STATE_PAUSED, GST_STATE_PLAYING}) {
    gst_element_set_state(pipeline_.get(), state);
    if (gst_element_get_state(pipeline_.get(), nullptr, nullptr, kPatienceOfGst) !=
        GST_STATE_CHANGE_SUCCESS)
      return std::string("does not reach ") + gst_element_state_get_name(state) + "\n";
  }
  return "";
}

std::string EditedPipeline::edit_pads(RequestPads& pads) {
  const size_t have = pads.size();
  if (have == 0 || (have < kMaxRequestPads && any(2) == 0)) return pads.add();
  return pads.remove(static_cast<size_t>(any(static_cast<int>(have))));
}

std::string EditedPipeline::change() {
  switch (any(12)) {
    case 0:
    case 1:
    case 2:
      add_branch();
      return "";
    case 3:
    case 4:
      return remove_branch(Removal::Drained);
    case 5:
      return remove_branch(Removal::Abrupt);
    case 6:
      g_object_set(find("valve").get(), "drop", any(2), nullptr);
      return "";
    case 7:
      g_object_set(find("in").get(), "active-pad", pad("in", any(2) ? "sink_0" : "sink_1").get(),
                   nullptr);
      gst::switch_output(pad("out", any(2) ? "src_0" : "src_1"));
      return "";
    case 8:
      width_ = 8 + any(4) * 8;
      return "";
    case 9:
      return pause();
    case 10:
      return edit_pads(*mux_pads_);
    default:
      return edit_pads(*join_pads_);
  }
}

std::string EditedPipeline::bus_error() const {
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  const std::string text = std::string(GST_MESSAGE_SRC_NAME(message.get())) + ": " + error->message;
  g_error_free(error);
  return text + "\n";
}

std::string EditedPipeline::edit() {
  ++edits_;
  std::string wrong = change();
  const auto& arrivals = always_->arrivals();
  if (!arrivals.waits_for(arrivals.frames() + 20)) wrong += "the stream stands still\n";
  for (const auto& branch : branches_)
    if (branch->arrivals().faults() > 0) wrong += "frames damaged or out of place\n";
  if (muxed_.faults() > 0) wrong += "tensor_mux pairs frames of different times\n";
  if (joined_.faults() > 0) wrong += "join damages frames\n";
  wrong += bus_error();
  return wrong.empty()
             ? ""
             : "seed " + std::to_string(seed_) + ", edit " + std::to_string(edits_) + ": " + wrong;
}

std::string EditedPipeline::finish() {
  std::string wrong;
  while (!branches_.empty()) wrong += remove_branch(Removal::Drained);
  // EOS on the first branch of join ends it, while others may still have frames, so remove them
  // first.
  while (join_pads_->size() > 0) wrong += join_pads_->remove(0);
  over_ = true;
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
  const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
      bus.get(), kPatienceOfGst, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  if (!message)
    wrong += "the stream does not end\n";
  else if (GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR)
    wrong += "an error at the end\n";
  wrong += check_ledgers(GST_BIN(pipeline_.get()), nullptr);
  lost_ += fed_ - always_->arrivals().frames();
  if (always_->arrivals().frames() != fed_)
    wrong += std::to_string(fed_) + " frames fed, " + std::to_string(always_->arrivals().frames()) +
             " arrived where nothing may be lost\n";
  wrong += always_->remove(Removal::Abrupt);
  return wrong.empty() ? "" : "seed " + std::to_string(seed_) + ", at the end: " + wrong;
}

}  // namespace weir::soak
