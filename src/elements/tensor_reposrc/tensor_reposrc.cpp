// tensor_reposrc: the start of a loop; pushes a frame of zeros, then the frames that
// tensor_reposink puts into the slot.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <cstring>
#include <optional>
#include <string>

#include "core/records/result_frame.hpp"
#include "elements/tensor_reposink/repository.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/buffer/result_output.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir {
namespace {

using gst::Ref;

constexpr int kMaxElements = 64;  // a pipeline may contain loops

// "" for an element that does not synchronise.
std::string get_sync_mode(GstElement* element) {
  const auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), "sync-mode");
  if (!spec || spec->value_type != G_TYPE_STRING) return "";
  char* raw = nullptr;
  g_object_get(element, "sync-mode", &raw, nullptr);
  const gst::UniqueText text{raw};
  return raw ? raw : "";
}

Error unfit(GstElement* element, const std::string& mode) {
  const gst::UniqueText name{gst_element_get_name(element)};
  return {.code = Code::GRAPH_STALLS,
          .what = std::string("a loop goes through ") + name.get() +
                  ", which synchronises by timestamps",
          .offered = "sync-mode=" + mode + ", while frames of a loop are one round old",
          .needed =
              "sync-mode=nosync: slowest and basepad drop these frames as late and wait; refresh "
              "never ends",
          .fix = std::string("name=") + name.get() + " sync-mode=nosync"};
}

// Walks downstream from `source` to the first element that synchronises several streams. Returns an
// error if it does so by time.
std::optional<Error> unfit_sync_mode(GstPad* source) {
  auto pad = Ref<GstPad>::share(source);
  for (int i = 0; pad && i < kMaxElements; ++i) {
    const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(pad.get()));
    if (!peer) break;
    const auto element = Ref<GstElement>::adopt(gst_pad_get_parent_element(peer.get()));
    if (!element) break;
    if (const std::string mode = get_sync_mode(element.get()); !mode.empty()) {
      if (g_ascii_strcasecmp(mode.c_str(), "nosync") == 0) break;
      return unfit(element.get(), mode);
    }
    pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  }
  return std::nullopt;
}

using gst::Ref;

constexpr uint32_t kNotSet = UINT32_MAX;
constexpr char kSampleCaps[] =
    "tensor_reposrc slot-index=0 "
    "caps=\"other/tensor,dimension=(string)4:1:1:1,type=float32,framerate=30/1\"";
constexpr char kSampleOfResults[] =
    "tensor_reposrc slot-index=0 caps='other/tensors,format=flexible,framerate=30/1,"
    "weir-columns=(string)\"x1,y1,x2,y2,score,class\"'";

using gst::to_string;

Result<FrameSpec> spec_with_roles(const GstCaps* caps) {
  auto spec = gst::fixed_spec_from_caps(caps);
  if (spec) spec->roles = gst::roles_from_caps(caps);
  return spec;
}

std::string to_string(const Fraction& rate) {
  return std::to_string(rate.numerator) + "/" + std::to_string(rate.denominator);
}

// Returns "" when frames of `offered` match `needed`, regardless of the spelling of dimensions and
// of other/tensor or other/tensors for one tensor. Columns are compared if both have them.
std::string describe_difference(const FrameSpec& offered, const FrameSpec& needed) {
  const auto differs = [](const char* field, std::string_view one, std::string_view other) {
    return std::string(field) + " is " + std::string(one) + ", needed is " + std::string(other);
  };
  if (offered.format != needed.format)
    return differs("format", to_string(offered.format), to_string(needed.format));
  std::string tensors = first_difference(offered.tensors, needed.tensors);
  if (!tensors.empty()) return tensors;
  if (!(offered.rate == needed.rate))
    return differs("framerate", to_string(offered.rate), to_string(needed.rate));
  if (offered.roles.empty() || needed.roles.empty()) return "";
  const std::string columns = columns_text(offered.roles), wanted = columns_text(needed.roles);
  return columns == wanted ? "" : differs("weir-columns", columns, wanted);
}

class TensorReposrc : public gst::Element<TensorReposrc, gst::PushSource> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirTensorReposrc", "tensor_reposrc", "TensorRepoSrc", "Source/Tensor/Repository",
      "Starts a loop with zeros, then pushes the frames of the tensor_reposink of the same slot"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE(
          "src", GST_PAD_SRC, GST_PAD_ALWAYS,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR
                          "; other/tensors, "
                          "format=(string)static, num_tensors=(int)[ 1, 256 ], " WEIR_CAPS_RATE
                          "; " WEIR_CAPS_TENSORS("flexible"))),
  };

  struct Settings {
    Ref<GstCaps> caps;
    uint32_t slot_index = kNotSet;
    bool silent = true;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"caps", &Settings::caps, "Fixed tensor caps of the frames of the loop",
                    gst::Changeable::WhilePlaying},
      gst::Property{"slot-index", &Settings::slot_index,
                    "Number of the slot from which frames come", gst::Changeable::WhilePlaying, 0u,
                    kNotSet - 1},
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
  };

  void constructed() {
    gst_base_src_set_format(GST_BASE_SRC(self()), GST_FORMAT_TIME);
    const auto mask =
        GstPadProbeType(GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM | GST_PAD_PROBE_TYPE_EVENT_FLUSH);
    gst_pad_add_probe(
        pad(), mask,
        [](GstPad*, GstPadProbeInfo* info, gpointer impl) {
          static_cast<TensorReposrc*>(impl)->sees(GST_PAD_PROBE_INFO_EVENT(info));
          return GST_PAD_PROBE_OK;
        },
        this, nullptr);
    gst::keep_queries_on_own_thread(pad(), &ledger_);
  }

  Status check_change(const char* name, const Settings& wanted) const {
    return std::string_view(name) == "caps" ? check_caps(wanted.caps) : ok();
  }
  // Other properties take effect immediately.
  static bool is_followed(std::string_view name) { return name == "caps"; }
  void property_changed(const char* name) {
    if (std::string_view(name) != "slot-index") return;
    count_left(reader_.move(settings().slot_index));
    report_others();
  }

  Status start() {
    const Settings s = take_settings(&followed_);
    if (auto status = check_caps(s.caps); !status) return status;
    if (s.slot_index == kNotSet)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "the property slot-index is not set",
                   .needed = "the slot-index of the tensor_reposink that ends the loop",
                   .fix = "tensor_reposrc slot-index=0"};
    if (auto status = plan(s.caps); !status) return status;
    ledger_.reset();
    fresh_ = true;
    reader_.attach(s.slot_index);
    report_others();
    return ok();
  }

  gboolean stop() {
    count_left(reader_.detach());
    checked_ = sent_ = {};
    roles_.clear();
    sent_labels_ = nullptr;
    return TRUE;
  }

  GstCaps* get_caps(GstCaps* filter) {
    const Settings s = settings();
    auto caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad()));
    if (const auto spec =
            s.caps ? gst::fixed_spec_from_caps(s.caps.get()) : Result<FrameSpec>(Error{})) {
      const auto others = gst::possible_caps(pad(), *spec, filter);
      caps = Ref<GstCaps>::adopt(
          gst_caps_merge(gst_caps_ref(s.caps.get()), gst_caps_ref(others.get())));
    }
    if (!filter) return caps.release();
    return gst_caps_intersect_full(filter, caps.get(), GST_CAPS_INTERSECT_FIRST);
  }

  // The frames are allocated already: no pool is needed.
  gboolean decide_allocation(GstQuery* query) {
    while (gst_query_get_n_allocation_pools(query) > 0)
      gst_query_remove_nth_allocation_pool(query, 0);
    return TRUE;
  }

  GstFlowReturn create(GstBuffer** out) {
    if (std::exchange(fresh_, false)) {
      reader_.begin_again();
      if (const auto unfit = unfit_sync_mode(pad())) gst::post_warning(element(), *unfit);
      return zeros(out);
    }
    auto taken = reader_.take();
    switch (taken.outcome) {
      case loop::Take::Interrupted:
        return GST_FLOW_FLUSHING;
      case loop::Take::Ended:
        return GST_FLOW_EOS;
      case loop::Take::Restarted:
        return zeros(out);
      case loop::Take::Frame:
        break;
    }
    taken.frame->ledger->consumed();
    ledger_.received();
    if (const Status status = check(taken.frame->caps); !status) {
      ledger_.dropped(DropReason::Error);
      gst::post_error(element(), status.error());
      return GST_FLOW_EOS;
    }
    send_roles();
    send_labels(taken.frame->labels);
    ledger_.consumed_and_pushed();
    *out = taken.frame->buffer.release();
    return GST_FLOW_OK;
  }

  gboolean unlock() {
    reader_.interrupt();
    return TRUE;
  }
  gboolean unlock_stop() {
    reader_.resume();
    return TRUE;
  }

  Settings settings_;
  Ledger ledger_;
  BufferLimit buffer_limit_{kInfo.factory_name};

 private:
  GstPad* pad() const { return GST_BASE_SRC_PAD(self()); }

  // If a frame goes to another source, the loop stalls without an error.
  void report_others() {
    if (!reader_.shares_slot()) return;
    const uint32_t slot = settings().slot_index;
    const std::string index = "slot-index=" + std::to_string(slot);
    gst::post_warning(
        element(),
        Error{.code = Code::GRAPH_STALLS,
              .what = "two sources read frames from one slot",
              .offered = "another tensor_reposrc " + index,
              .needed = "a slot for each tensor_reposrc: each frame goes to only one of them",
              .fix = "tensor_reposrc slot-index=" + std::to_string(slot + 1)});
  }

  // Watches downstream events. After EOS no more frames are read, and the sink must not wait.
  void sees(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) reader_.end();
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) reader_.begin();
  }

  static Status check_caps(const Ref<GstCaps>& caps) {
    if (!caps)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "the property caps is not set",
                   .needed = "the caps of the frames in the loop",
                   .fix = kSampleCaps};
    const auto spec = gst::fixed_spec_from_caps(caps.get());
    if (!spec) {
      Error error = spec.error();
      error.fix = kSampleCaps;
      return error;
    }
    return spec->format == Format::Static ? ok() : check_headered(caps.get(), spec->format);
  }
  // The caps of flexible tensors do not give their sizes: the first frame is one without results.
  static Status check_headered(const GstCaps* caps, Format format) {
    if (format != Format::Flexible)
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "a loop carries static or flexible tensors only",
                   .offered = to_string(caps),
                   .needed = "format=static, or format=flexible with weir-columns",
                   .fix = kSampleCaps};
    const ResultRoles roles = gst::roles_from_caps(caps);
    if (roles.empty())
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "the caps do not describe the first frame of the loop",
                   .offered = to_string(caps),
                   .needed =
                       "format=static, or for flexible tensors weir-columns: the first frame "
                       "then has one row of zeros",
                   .fix = kSampleOfResults};
    const auto reader = records::ResultReader::make(columns_text(roles), sources_text(roles));
    return reader ? ok() : Status(reader.error());
  }

  Status plan(const Ref<GstCaps>& caps) {
    auto spec = spec_with_roles(caps.get());
    if (!spec) return spec.error();
    if (spec->format == Format::Static) {
      if (auto status = buffer_limit_.check(*spec); !status) return status;
      auto pool = gst::FramePool::make(spec->tensors, Format::Static);
      if (!pool) return pool.error();
      pool_ = *std::move(pool);
    }
    empty_.configure(caps.get());
    caps_ = caps;
    spec_ = *std::move(spec);
    return ok();
  }

  // A frame of zeros, or of no results, without a timestamp.
  GstFlowReturn zeros(GstBuffer** out) {
    auto buffer =
        spec_.format == Format::Static ? frame_of_zeros() : empty_.empty_frame(buffer_limit_);
    if (!buffer) {
      gst::post_error(element(), buffer.error());
      return GST_FLOW_ERROR;
    }
    ledger_.pushed();
    *out = buffer->release();
    return GST_FLOW_OK;
  }
  Result<Ref<GstBuffer>> frame_of_zeros() {
    auto buffer = pool_.acquire(buffer_limit_);
    if (!buffer) return buffer;
    gst::FramePool::Writer writer;
    if (const Status status = writer.map(pool_, buffer->get()); !status) return status.error();
    for (const auto& payload : writer.payloads()) std::memset(payload.data(), 0, payload.size());
    return buffer;
  }

  // A loop begins with a frame of a known size, which flexible caps do not give.
  std::string fix_for(const FrameSpec& frames, const GstCaps* caps) const {
    if (frames.format == Format::Flexible && spec_.format == Format::Static)
      return "tensor_converter ! tensor_reposink " + slot();
    return with_caps(caps);
  }
  std::string slot() const { return "slot-index=" + std::to_string(settings().slot_index); }
  std::string with_caps(const GstCaps* caps) const {
    return "tensor_reposrc " + slot() + " caps=\"" + to_string(caps) + "\"";
  }

  // Applies the property caps, set while frames flow, at the first frame that matches them.
  void follow_caps(const FrameSpec& frame) {
    const auto spec = spec_with_roles(settings().caps.get());
    if (!spec || !describe_difference(frame, *spec).empty()) return;
    follow_settings(&followed_, [&](const Settings& wanted) -> Status {
      if (auto status = gst::check_downstream(pad(), wanted.caps.get(), with_caps(caps_.get()));
          !status)
        return status;
      if (auto status = plan(wanted.caps); !status) return status;
      gst_base_src_set_caps(GST_BASE_SRC(self()), wanted.caps.get());
      return ok();
    });
  }

  Status check(const Ref<GstCaps>& caps) {
    if (caps.get() == checked_.get()) return ok();
    const auto spec = spec_with_roles(caps.get());
    if (!spec) return spec.error();
    if (is_written()) follow_caps(*spec);
    const std::string difference = describe_difference(*spec, spec_);
    if (!difference.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the frames of the tensor_reposink do not match the property caps",
                   .offered = to_string(caps.get()),
                   .needed = to_string(caps_.get()),
                   .difference = difference,
                   .fix = fix_for(*spec, caps.get())};
    checked_ = caps;
    roles_ = spec->roles.empty() ? spec_.roles : spec->roles;
    return ok();
  }

  // The fields of results are those of the frames: the property may leave them out.
  void send_roles() {
    auto current = Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad()));
    if (!current || current.get() == sent_.get()) return;
    if (gst::roles_from_caps(current.get()) != roles_) {
      current = gst::with_roles(Ref<GstCaps>::adopt(gst_caps_copy(current.get())), roles_);
      gst_base_src_set_caps(GST_BASE_SRC(self()), current.get());
    }
    sent_ = current;
  }

  // Sends the names of classes that came with the stream of the tensor_reposink. Those of an
  // earlier stream are taken back.
  void send_labels(const std::shared_ptr<const LabelsBySource>& labels) {
    if (labels == sent_labels_) return;
    LabelsBySource all;
    if (sent_labels_)
      for (const auto& [source, sent] : *sent_labels_) all[source] = {source, {}};
    if (labels)
      for (const auto& [source, given] : *labels) all[source] = given;
    for (const auto& [source, given] : all)
      gst_pad_push_event(pad(), gst::make_labels_event(given).release());
    sent_labels_ = labels;
  }

  Repository::Reader reader_{repository(), {[this](uint32_t slot) {
                               gst::post_warning(element(), lone_end("tensor_reposink", slot));
                             }}};
  // Set in start(), then streaming thread only.
  gst::LiveSettings<Settings> followed_;  // the settings of caps_
  bool fresh_ = true;
  Ref<GstCaps> caps_;     // the property
  Ref<GstCaps> checked_;  // frame caps known to match caps_
  ResultRoles roles_;     // of checked_
  Ref<GstCaps> sent_;     // caps of the pad with roles_
  std::shared_ptr<const LabelsBySource> sent_labels_;
  FrameSpec spec_;           // of caps_
  gst::ResultOutput empty_;  // the frame without results of caps_
  gst::FramePool pool_;
};

}  // namespace

bool register_tensor_reposrc(GstPlugin* plugin) {
  return TensorReposrc::register_in(plugin);
}

}  // namespace weir
