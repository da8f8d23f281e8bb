// tensor_demux: sends each tensor of a frame, or each group of tensors, on its own source pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <numeric>

#include "core/split/pick_list.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/pads/one_to_many.hpp"

namespace weir {
namespace {

using gst::Ref;

class TensorDemux : public gst::OneToMany<TensorDemux> {
 public:
  static constexpr gst::ElementInfo kInfo{"WeirTensorDemux", "tensor_demux", "TensorDemux",
                                          "Demuxer/Tensor",
                                          "Sends each tensor of a frame to its own pad"};
  static constexpr const char* kSourceTemplate = "src_%u";
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                              GST_STATIC_CAPS(WEIR_CAPS_TENSORS("{ static, flexible }"))),
      GST_STATIC_PAD_TEMPLATE(
          "src_%u", GST_PAD_SRC, GST_PAD_SOMETIMES,
          GST_STATIC_CAPS(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("{ static, flexible }"))),
  };

  struct Settings {
    bool silent = true;
    std::string tensorpick;
  };
  static constexpr std::tuple kProperties{
      gst::Property{"silent", &Settings::silent, "Accepted for compatibility; has no effect",
                    gst::Changeable::WhilePlaying},
      gst::Property{"tensorpick", &Settings::tensorpick,
                    "Tensors to output: ',' separates pads, ':' separates the tensors of one pad, "
                    "as in 0,1:2; empty = each on its own pad",
                    gst::Changeable::WhilePlaying},
  };

  Status prepare(const Settings& settings) {
    auto groups = parse_tensor_groups("tensorpick", settings.tensorpick);
    if (!groups) return groups.error();
    picked_ = *std::move(groups);
    groups_.clear();
    return ok();
  }

  Status check_change(const char*, const Settings& wanted) const {
    const auto groups = parse_tensor_groups("tensorpick", wanted.tensorpick);
    return groups ? ok() : Status(groups.error());
  }
  // Pads without a group stay, but get no more buffers.
  Status follow(const Settings& settings) {
    auto groups = parse_tensor_groups("tensorpick", settings.tensorpick);
    if (!groups) return groups.error();
    const auto& tensors = spec_.tensors;
    for (const auto& group : *groups)
      for (const size_t index : group)
        if (spec_.format == Format::Static && index >= tensors.size())
          return index_beyond("tensorpick", "tensor", index, tensors.size());
    for (size_t i = 0; i < (groups->empty() ? tensors.size() : groups->size()); ++i)
      if (auto status =
              outputs_.takes(i, make_spec(groups->empty() ? std::vector{i} : (*groups)[i]));
          !status)
        return status;
    picked_ = *std::move(groups);
    outputs_.unsettle();
    return configure(FrameSpec(spec_));
  }

  Status configure(const FrameSpec& spec) {
    spec_ = spec;
    groups_.clear();
    for (const auto& tensors : picked_) add_group(tensors);
    if (picked_.empty()) one_group_each(spec.tensors.size());
    outputs_.expect(groups_.size());
    return ok();
  }

  Result<gst::Routed> route(const Ref<GstBuffer>& buffer) {
    if (auto status = layout_.locate(buffer.get(), spec_); !status) return status.error();
    if (picked_.empty() && layout_.tensors().size() > groups_.size()) {
      one_group_each(layout_.tensors().size());
      outputs_.expect(groups_.size());
    }
    // Checked here and not with the caps, which may be those of a placeholder. In a flexible stream
    // the number of tensors varies by frame.
    for (const Group& group : groups_)
      if (spec_.format == Format::Static && !is_there(group)) return missing(group);
    for (size_t i = 0; i < groups_.size(); ++i) outputs_.output(i);
    // Before the first push: the sink of the first pad may block until another pad, which gets
    // nothing, has a buffer.
    for (Group& group : groups_) warn_if_missing(&group);
    return push_groups(buffer.get());
  }

  Result<gst::Routed> push_groups(GstBuffer* buffer) {
    gst::Routed routed{GST_FLOW_OK, true};
    for (size_t i = 0; i < groups_.size(); ++i) {
      if (!is_there(groups_[i])) continue;
      auto frame = make_frame(buffer, &groups_[i], &outputs_.output(i));
      if (!frame) return frame.error();
      routed.dropped = false;
      routed.flow = push(&outputs_.output(i), *std::move(frame));
      if (gst::SometimesPads::stops(routed.flow)) break;
    }
    return routed;
  }

  Settings settings_;
  gst::LiveSettings<Settings> followed_;  // streaming thread

 private:
  // The tensors of one pad.
  struct Group {
    std::vector<size_t> tensors;
    size_t highest = 0;
    FrameSpec spec;       // of the pad
    gst::FramePool pool;  // used if the pad needs headers on static tensors
    bool warned = false;
  };

  void add_group(const std::vector<size_t>& tensors) {
    groups_.push_back({tensors,
                       *std::max_element(tensors.begin(), tensors.end()),
                       make_spec(tensors),
                       {},
                       false});
  }
  // The spec of the pad for these tensors.
  FrameSpec make_spec(const std::vector<size_t>& tensors) const {
    const FrameSpec& whole = spec_;
    FrameSpec spec{whole.format, {}, whole.rate, pick_roles(whole.roles, tensors)};
    for (const size_t index : tensors)
      if (index < whole.tensors.size()) spec.tensors.push_back(whole.tensors[index]);
    return spec;
  }
  void one_group_each(size_t tensors) {
    for (size_t i = groups_.size(); i < tensors; ++i) add_group({i});
  }

  bool is_there(const Group& group) const { return group.highest < layout_.tensors().size(); }
  // Not without tensorpick: frames of a flexible stream may have fewer tensors than others.
  void warn_if_missing(Group* group) {
    if (is_there(*group) || picked_.empty() || std::exchange(group->warned, true)) return;
    gst::post_warning(element(), missing(*group));
  }
  Error missing(const Group& group) const {
    return index_beyond("tensorpick", "tensor", group.highest, layout_.tensors().size());
  }

  Result<Ref<GstBuffer>> make_frame(GstBuffer* in, Group* group,
                                    gst::SometimesPads::Output* output) {
    const auto changed = outputs_.settle(output, group->spec);
    if (!changed) return changed.error();
    const bool add_headers = output->format == Format::Flexible && spec_.format == Format::Static;
    if (*changed) group->pool = {};
    if (add_headers && !group->pool) {
      auto pool = gst::FramePool::make(group->spec.tensors, Format::Flexible);
      if (!pool) return pool.error();
      group->pool = *std::move(pool);
    }
    uint64_t copied = 0;
    auto frame = add_headers ? gst::copy_tensors(in, layout_, group->tensors, &group->pool, &copied)
                             : gst::pick_tensors(in, layout_, group->tensors, &copied);
    if (copied > 0) ledger_.copied(copied);
    return frame;
  }

  // Streaming thread:
  TensorGroups picked_;  // from tensorpick
  std::vector<Group> groups_;
  FrameSpec spec_;  // of the input
  gst::FrameLayout layout_;
};

}  // namespace

bool register_tensor_demux(GstPlugin* plugin) {
  return TensorDemux::register_in(plugin);
}

}  // namespace weir
