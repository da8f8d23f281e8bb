// Branches: a test bench with an element with one input and sometimes pads, between bare pads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "elements/tests/element_parts_test_support.hpp"

namespace weir::test {

using gst::Ref;
using gst::UniqueText;
using test::Bytes;
using test::content;

inline Bytes content(GstBuffer* buffer, guint index) {
  return content(gst_buffer_peek_memory(buffer, index));
}
// One memory per tensor.
inline GstBuffer* make_frame(const std::vector<Bytes>& tensors) {
  GstBuffer* buffer = gst_buffer_new();
  for (const auto& bytes : tensors) gst_buffer_append_memory(buffer, test::make_memory(bytes));
  return buffer;
}
inline constexpr char kFlexibleBranch[] = "other/tensors,format=flexible,framerate=30/1";

class Branches {
 public:
  struct Branch {
    Ref<GstPad> pad;
    std::vector<Ref<GstBuffer>> buffers;
    std::vector<std::string> events;  // names in order; read only while no thread sends events
    std::mutex mutex;                 // guards events: a flush may start on another thread
    GstFlowReturn flow = GST_FLOW_OK;
    std::string caps() const { return test::current_caps(pad.get()); }
    std::string stream_id() const {
      const UniqueText text{gst_pad_get_stream_id(pad.get())};
      return text.get();
    }
  };

  // `taken`: the caps that each pad's peer accepts, ANY by default.
  explicit Branches(const std::string& launch, std::map<std::string, std::string> taken = {},
                    std::set<std::string> unlinked = {})
      : taken_(std::move(taken)), unlinked_(std::move(unlinked)) {
    element_ = test::lone_element(launch);
    bus_ = Ref<GstBus>::adopt(gst_bus_new());
    gst_element_set_bus(element_.get(), bus_.get());
    g_signal_connect(element_.get(), "pad-added", G_CALLBACK(pad_added), this);
    g_signal_connect(element_.get(), "no-more-pads", G_CALLBACK(no_more_pads), this);
    source_ = test::lone_pad(gst_pad_new("source", GST_PAD_SRC));
    const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "sink"));
    gst_pad_link(source_.get(), sink.get());
    gst_pad_set_active(source_.get(), TRUE);
    started_ = gst_element_set_state(element_.get(), GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE;
    send(gst_event_new_stream_start("test"));
  }
  Branches(const Branches&) = delete;
  Branches& operator=(const Branches&) = delete;
  ~Branches() {
    gst_element_set_state(element_.get(), GST_STATE_NULL);
    gst_pad_set_active(source_.get(), FALSE);
    gst_element_set_bus(element_.get(), nullptr);
    for (const auto& [name, branch] : branches_) gst_pad_set_active(branch->pad.get(), FALSE);
  }

  bool started() const { return started_; }
  GstElement* element() const { return element_.get(); }
  bool send(GstEvent* event) { return gst_pad_push_event(source_.get(), event); }
  // Also sends a segment after the first caps.
  void caps(const std::string& text) {
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
    send(gst_event_new_caps(caps.get()));
    if (std::exchange(segment_sent_, true)) return;
    send(test::time_segment());
  }
  GstFlowReturn push(GstBuffer* buffer) { return gst_pad_push(source_.get(), buffer); }
  // The only frame that reached the pad since the last call.
  Ref<GstBuffer> take(const std::string& name) {
    auto buffers = std::exchange(branch(name).buffers, {});
    EXPECT_EQ(buffers.size(), 1u) << name;
    return buffers.empty() ? Ref<GstBuffer>() : buffers[0];
  }

  bool has(const std::string& name) const { return branches_.count(name) > 0; }
  Branch& branch(const std::string& name) {
    EXPECT_TRUE(has(name)) << name;
    return *branches_.try_emplace(name, std::make_unique<Branch>()).first->second;
  }
  const std::vector<std::string>& added() const { return added_; }
  int no_more_pads_count() const { return no_more_pads_; }

  std::string message(GstMessageType type) {
    const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus_.get(), type));
    if (!message) return "";
    last_ = test::error_in(message.get());
    return last_->message;
  }
  std::string error() { return message(GST_MESSAGE_ERROR); }
  std::string warning() { return message(GST_MESSAGE_WARNING); }
  // Of the last message.
  std::string domain() const { return g_quark_to_string(last_->domain); }
  int code() const { return last_->code; }

  uint64_t stat(const char* name) const { return test::stat(element_.get(), name); }
  // received = consumed + dropped; held is 0.
  void expect_balance() const {
    EXPECT_EQ(stat("received"), stat("consumed") + stat("dropped"));
    EXPECT_EQ(stat("held"), 0u);
  }

 private:
  static void no_more_pads(GstElement*, gpointer self) {
    ++static_cast<Branches*>(self)->no_more_pads_;
  }
  static void pad_added(GstElement*, GstPad* pad, gpointer data) {
    auto* self = static_cast<Branches*>(data);
    if (GST_PAD_IS_SINK(pad)) return;
    const UniqueText raw{gst_object_get_name(GST_OBJECT(pad))};
    const std::string name = raw.get();
    self->added_.push_back(name);
    if (self->unlinked_.count(name) == 0) self->join(pad, name);
  }
  void join(GstPad* pad, const std::string& name) {
    const auto known = taken_.find(name);
    auto branch = std::make_unique<Branch>();
    branch->pad = test::lone_sink_pad(known == taken_.end() ? "ANY" : known->second, name);
    GstPad* sink = branch->pad.get();
    gst_pad_set_element_private(sink, branch.get());
    gst_pad_set_chain_function(sink, [](GstPad* to, GstObject*, GstBuffer* buffer) {
      auto* own = static_cast<Branch*>(gst_pad_get_element_private(to));
      own->buffers.push_back(Ref<GstBuffer>::adopt(buffer));
      return own->flow;
    });
    gst_pad_set_event_function(sink, [](GstPad* to, GstObject*, GstEvent* event) -> gboolean {
      auto* own = static_cast<Branch*>(gst_pad_get_element_private(to));
      {
        std::lock_guard lock(own->mutex);
        own->events.emplace_back(GST_EVENT_TYPE_NAME(event));
      }
      gst_event_unref(event);
      return TRUE;
    });
    gst_pad_set_active(sink, TRUE);
    EXPECT_EQ(gst_pad_link(pad, sink), GST_PAD_LINK_OK);
    branches_[name] = std::move(branch);
  }

  std::map<std::string, std::string> taken_;
  std::set<std::string> unlinked_;
  Ref<GstElement> element_;
  Ref<GstBus> bus_;
  Ref<GstPad> source_;
  bool started_ = false, segment_sent_ = false;
  std::vector<std::string> added_;
  int no_more_pads_ = 0;
  gst::Unique<GError, g_error_free> last_;  // message
  std::map<std::string, std::unique_ptr<Branch>> branches_;
};

}  // namespace weir::test
