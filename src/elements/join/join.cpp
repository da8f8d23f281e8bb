// join: merges branches into one stream; forwards the branch that delivered a buffer last.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/sync/shared_output.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/internal_links.hpp"
#include "gstcpp/element/ref.hpp"
#include "gstcpp/pads/streaming_threads.hpp"

namespace weir {
namespace {

using gst::Ref;

// How long the EOS of the active branch waits for a buffer or EOS of the other branches.
constexpr std::chrono::seconds kEndTimeout{1};

// A serialized event that join sends through the queues of its branches and consumes on arrival.
constexpr char kMarker[] = "weir-join-marker";

class Join : public gst::Element<Join, gst::PlainElement> {
 public:
  static constexpr gst::ElementInfo kInfo{
      "WeirJoin", "join", "Input join", "Generic",
      "Merges branches that deliver one at a time into one stream"};
  static inline GstStaticPadTemplate kPads[] = {
      GST_STATIC_PAD_TEMPLATE("sink_%u", GST_PAD_SINK, GST_PAD_REQUEST, GST_STATIC_CAPS_ANY),
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY),
  };
  struct Settings {};
  uint32_t n_pads() const {
    GST_OBJECT_LOCK(self());
    const uint32_t count = self()->numsinkpads;
    GST_OBJECT_UNLOCK(self());
    return count;
  }
  Ref<GstPad> active_pad() const { return output_.active(); }
  static constexpr std::tuple kProperties{
      gst::ReadOnly{"n-pads", &Join::n_pads, "Number of branches"},
      gst::ReadOnly{"active-pad", &Join::active_pad, "Branch that delivered the last frame"},
  };

  void constructed() {
    source_ = gst_pad_new_from_template(
        gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(element()), "src"), "src");
    GST_PAD_SET_PROXY_CAPS(source_);
    gst_element_add_pad(element(), source_);
  }

  GstPad* request_new_pad(GstPadTemplate* pad_template, const gchar* wanted, const GstCaps*) {
    std::string name = wanted ? wanted : "";
    while (name.empty() || (!wanted && has_pad(name))) name = "sink_" + std::to_string(next_pad_++);
    GstPad* pad = gst_pad_new_from_template(pad_template, name.c_str());
    gst_pad_set_chain_function(pad, pad_chain<&Join::on_buffer>);
    gst_pad_set_event_function(pad, pad_event<&Join::on_event>);
    gst_pad_set_query_function(pad, pad_query<&Join::on_query>);
    GST_PAD_SET_PROXY_CAPS(pad);
    GST_PAD_SET_PROXY_ALLOCATION(pad);
    gst_pad_set_element_private(pad, this);
    gst_pad_set_activatemode_function(pad, on_activate);
    forget(pad);  // a thread of a pad that had this address may have come back after its release
    gst_pad_set_active(pad, TRUE);
    if (!gst_element_add_pad(element(), pad)) {  // the name is taken
      output_.remove(Ref<GstPad>::adopt(GST_PAD_CAST(gst_object_ref_sink(pad))));
      return nullptr;
    }
    g_object_notify(G_OBJECT(self()), "n-pads");
    return pad;
  }
  void release_pad(GstPad* pad) {
    const auto input = Ref<GstPad>::share(pad);
    // A thread that downstream blocks returns later, when the pad is gone.
    if (!output_.close(input)) gst_pad_set_active(pad, FALSE);
    const bool was_active = output_.remove(input);  // from here on it cannot start a flush
    send_flush_stop(input);
    gst_element_remove_pad(element(), pad);
    forget(pad);
    if (was_active) g_object_notify(G_OBJECT(self()), "active-pad");
    g_object_notify(G_OBJECT(self()), "n-pads");
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) ledger_.reset();
    const auto result = parent_class()->change_state(element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) {
      output_.reset();
      {
        std::lock_guard lock(ended_mutex_);
        ended_.clear();
        threads_.clear();
        own_threads_.clear();
      }
      stream_id_.clear();
      g_object_notify(G_OBJECT(self()), "active-pad");
    }
    return result;
  }

  GstFlowReturn on_buffer(GstPad* pad, GstBuffer* raw) {
    auto buffer = Ref<GstBuffer>::adopt(raw);
    ledger_.received();
    note_buffer_thread(pad);
    const auto access = output_.acquire_as_active(Ref<GstPad>::share(pad));
    if (access == Output::Access::Denied) {
      ledger_.dropped(DropReason::Flush);
      return GST_FLOW_FLUSHING;
    }
    const Turn turn(&output_);
    if (GST_PAD_IS_EOS(source_)) {
      ledger_.dropped(DropReason::Eos);
      return GST_FLOW_EOS;
    }
    if (access == Output::Access::Switched) send_sticky_events(pad);
    const auto flow = gst_pad_push(source_, buffer.release());
    if (flow == GST_FLOW_EOS)
      ledger_.dropped(DropReason::Eos);
    else if (flow == GST_FLOW_FLUSHING)
      ledger_.dropped(DropReason::Flush);
    else
      ledger_.consumed_and_pushed();
    return flow;
  }

  gboolean on_event(GstPad* pad, GstEvent* event) {
    const auto type = GST_EVENT_TYPE(event);
    auto owned = Ref<GstEvent>::adopt(event);
    if (note_marker(pad, event)) return TRUE;
    if (type == GST_EVENT_CAPS && !accepts_caps(pad, event)) return FALSE;
    if (type == GST_EVENT_CAPS || type == GST_EVENT_SEGMENT) remember_thread(pad);
    const auto input = Ref<GstPad>::share(pad);
    if (type == GST_EVENT_FLUSH_START) return on_flush_start(input, std::move(owned));
    if (type == GST_EVENT_FLUSH_STOP) {
      forget_end(pad);
      send_flush_stop(input, std::move(owned));
      output_.open(input);
      return TRUE;
    }
    // A stream that starts after EOS, and the EOS of the last branch, are forwarded from any
    // branch.
    const bool begins = type == GST_EVENT_STREAM_START && GST_PAD_IS_EOS(source_);
    const bool last = note_end(pad, type) || begins;
    if (output_.active() != input && !last) return pass_over(input, type);
    if (type == GST_EVENT_EOS && !last && others_may_deliver(pad) && !is_last_to_deliver(input))
      return TRUE;
    if (!(gst_event_type_get_flags(type) & GST_EVENT_TYPE_SERIALIZED))
      return gst_pad_push_event(source_, owned.release());
    return push_serialized(input, std::move(owned), last);
  }

  // A serialized query must not pass the buffer that is being pushed downstream.
  gboolean on_query(GstPad* pad, GstQuery* query) {
    if (!is_serialized(query)) return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
    if (!output_.acquire(Ref<GstPad>::share(pad))) return FALSE;
    const Turn turn(&output_);
    return gst_pad_query_default(pad, GST_OBJECT_CAST(self()), query);
  }

  Settings settings_;
  Ledger ledger_;

 private:
  bool accepts_caps(GstPad* pad, GstEvent* event) {
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const Status status = check_caps(pad, caps);
    if (!status) gst::post_error(element(), status.error());
    return static_cast<bool>(status);
  }
  gboolean on_flush_start(const Ref<GstPad>& input, Ref<GstEvent> event) {
    if (!output_.flush_start(input)) return TRUE;
    const gboolean sent = gst_pad_push_event(source_, event.release());
    output_.flush_sent();
    return sent;
  }
  // Waits for the buffer that is being pushed. `any_branch`: from branches that are not active too.
  gboolean push_serialized(const Ref<GstPad>& input, Ref<GstEvent> event, bool any_branch) {
    if (!output_.acquire(input)) return FALSE;
    const Turn turn(&output_);
    const auto type = GST_EVENT_TYPE(event.get());
    // Another branch may be active by now.
    if (const auto active = output_.active(); active && active != input && !any_branch)
      return pass_over(input, type);
    if (type == GST_EVENT_STREAM_START) remember_stream(event.get());
    return gst_pad_push_event(source_, event.release());
  }
  bool has_pad(const std::string& name) const {
    const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element(), name.c_str()));
    return static_cast<bool>(pad);
  }

  static bool is_serialized(GstQuery* query) {
    return (gst_query_type_get_flags(GST_QUERY_TYPE(query)) & GST_QUERY_TYPE_SERIALIZED) != 0;
  }

  using Output = sync::SharedOutput<Ref<GstPad>>;
  // Releases the output at the end of a scope.
  class Turn {
   public:
    explicit Turn(Output* output) : output_(output) {}
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() { output_->release(); }

   private:
    Output* const output_;
  };

  // GStreamer calls this before it waits for the pad's streaming thread; a thread that waits for
  // the output then returns.
  static gboolean on_activate(GstPad* pad, GstObject*, GstPadMode mode, gboolean active) {
    if (mode != GST_PAD_MODE_PUSH) return FALSE;
    auto* join = static_cast<Join*>(gst_pad_get_element_private(pad));
    const auto input = Ref<GstPad>::share(pad);
    if (active)
      join->output_.open(input);
    else
      join->output_.close(input);
    return TRUE;
  }

  // Ends the flush of the output if this branch started it.
  void send_flush_stop(const Ref<GstPad>& input, Ref<GstEvent> event = {}) {
    if (!output_.flush_stop(input)) return;
    gst_pad_push_event(source_, event ? event.release() : gst_event_new_flush_stop(TRUE));
    output_.flush_sent();
  }

  // The sticky events of an inactive branch stay on its pad until the branch becomes active.
  gboolean pass_over(const Ref<GstPad>& input, GstEventType type) {
    if ((gst_event_type_get_flags(type) & GST_EVENT_TYPE_STICKY) != 0 && type != GST_EVENT_EOS)
      output_.pass_over(input);
    return TRUE;
  }

  void forget(GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    std::erase(ended_, pad);
    threads_.erase(pad);
    own_threads_.erase(pad);
    std::lock_guard markers_lock(markers_mutex_);
    markers_.erase(pad);
  }
  void remember_thread(GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    threads_[pad] = std::this_thread::get_id();
  }
  // An element may send events on the thread that feeds it and buffers on threads of its own, as
  // tensor_filter with workers does.
  void note_buffer_thread(GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    const auto thread = threads_.find(pad);
    if (thread != threads_.end() && thread->second != std::this_thread::get_id())
      own_threads_.insert(pad);
  }
  bool has_own_threads(GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    return own_threads_.contains(pad);
  }
  // Whether another branch, fed by another thread, has not received EOS.
  bool others_may_deliver(GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    return any_other_sink(pad, [&](GstPad* other) { return may_deliver_locked(other, pad); });
  }
  bool may_deliver(GstPad* other, GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    return may_deliver_locked(other, pad);
  }
  bool may_deliver_locked(GstPad* other, GstPad* pad) {
    if (std::find(ended_.begin(), ended_.end(), other) != ended_.end()) return false;
    if (own_threads_.contains(other)) return true;
    const auto thread = threads_.find(other);
    if (thread == threads_.end()) return may_begin(other, pad);
    return thread->second != std::this_thread::get_id();
  }
  // `other` has received nothing yet: a thread that feeds it, but not `pad`, may not have run so
  // far.
  static bool may_begin(GstPad* other, GstPad* pad) {
    const auto theirs = gst::find_feed(other), own = gst::find_feed(pad);
    const auto delivers = [&own](const Ref<GstPad>& start) {
      const auto inputs = gst::linked_inside(start.get());
      return std::find(own.threads.begin(), own.threads.end(), start) == own.threads.end() &&
             (inputs.empty() || std::any_of(inputs.begin(), inputs.end(), [](const auto& input) {
                return gst_pad_is_linked(input.get());
              }));
    };
    return theirs.known && std::any_of(theirs.threads.begin(), theirs.threads.end(), delivers);
  }
  // Branches of one stream get EOS at the same time, while their queues still hold buffers. So the
  // EOS of the active branch waits, but not forever: another branch may be closed by a valve.
  bool is_last_to_deliver(const Ref<GstPad>& input) {
    const uint64_t wait = ++waits_;
    const auto sent = send_markers(input.get(), wait);
    bool all_arrived = false;
    const auto over = [&] {
      all_arrived = sent && markers(wait) == *sent;
      return GST_PAD_IS_EOS(source_) || all_arrived;
    };
    const bool stays = output_.stays_active(input, kEndTimeout, over);
    return stays || (all_arrived && !GST_PAD_IS_EOS(source_));
  }
  // If only the thread of `pad` fills the queues of the other branches, nothing enters them before
  // its event returns, so a marker is the last item of its queue. Returns the number of markers;
  // nullopt if another thread feeds a branch.
  std::optional<size_t> send_markers(GstPad* pad, uint64_t wait) {
    const auto own = gst::find_feed(pad);
    std::vector<Ref<GstPad>> queues;
    const bool others =
        own.known && own.threads.size() == 1 && any_other_sink(pad, [&](GstPad* other) {
          return may_deliver(other, pad) &&
                 (has_own_threads(other) || !add_queue(other, own.threads[0], &queues));
        });
    if (!own.known || own.threads.size() != 1 || others) return std::nullopt;
    for (const auto& queue : queues) {
      auto* marker = gst_structure_new(kMarker, "join", G_TYPE_POINTER, this, "wait", G_TYPE_UINT64,
                                       wait, nullptr);
      if (!gst_pad_send_event(queue.get(),
                              gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, marker)))
        return std::nullopt;
    }
    return queues.size();
  }
  // False unless only `thread` feeds `branch`. Adds the queue that it fills, unless nothing has
  // entered it yet.
  static bool add_queue(GstPad* branch, const Ref<GstPad>& thread, std::vector<Ref<GstPad>>* out) {
    const auto queue = gst::queue_filled_by(thread, branch);
    if (queue && *queue && has_begun(queue->get())) out->push_back(*queue);
    return queue.has_value();
  }
  static bool has_begun(GstPad* pad) {
    return static_cast<bool>(
        Ref<GstEvent>::adopt(gst_pad_get_sticky_event(pad, GST_EVENT_STREAM_START, 0)));
  }
  bool note_marker(GstPad* pad, GstEvent* event) {
    if (!gst_event_has_name(event, kMarker)) return false;
    gpointer join = nullptr;
    guint64 wait = 0;
    gst_structure_get(gst_event_get_structure(event), "join", G_TYPE_POINTER, &join, "wait",
                      G_TYPE_UINT64, &wait, nullptr);
    if (join != this) return false;
    {
      std::lock_guard lock(markers_mutex_);
      markers_[pad] = wait;
    }
    output_.wake();
    return true;
  }
  size_t markers(uint64_t wait) {
    std::lock_guard lock(markers_mutex_);
    return static_cast<size_t>(std::count_if(markers_.begin(), markers_.end(),
                                             [wait](const auto& m) { return m.second == wait; }));
  }

  void forget_end(GstPad* pad) {
    std::lock_guard lock(ended_mutex_);
    std::erase(ended_, pad);
  }

  void remember_stream(GstEvent* stream_start) {
    const gchar* id = nullptr;
    gst_event_parse_stream_start(stream_start, &id);
    stream_id_ = id ? id : "";
  }

  // Sends the sticky events of `pad`; stream-start only if the stream changed.
  void send_sticky_events(GstPad* pad) {
    g_object_notify(G_OBJECT(self()), "active-pad");
    const auto send = +[](GstPad*, GstEvent** event, gpointer user) -> gboolean {
      auto* join = static_cast<Join*>(user);
      const auto type = GST_EVENT_TYPE(*event);
      if (type == GST_EVENT_EOS) return TRUE;
      if (type == GST_EVENT_STREAM_START) {
        const gchar* id = nullptr;
        gst_event_parse_stream_start(*event, &id);
        if (id && join->stream_id_ == id) return TRUE;
        join->remember_stream(*event);
      }
      gst_pad_push_event(join->source_, gst_event_ref(*event));
      return TRUE;
    };
    gst_pad_sticky_events_foreach(pad, send, this);
  }

  template <class F>
  bool any_other_sink(GstPad* pad, F&& f) const {
    GST_OBJECT_LOCK(self());
    std::vector<Ref<GstPad>> pads;
    for (GList* l = self()->sinkpads; l; l = l->next)
      pads.push_back(Ref<GstPad>::share(static_cast<GstPad*>(l->data)));
    GST_OBJECT_UNLOCK(self());
    return std::any_of(pads.begin(), pads.end(),
                       [&](const auto& other) { return other.get() != pad && f(other.get()); });
  }

  // Whether this event ends the stream: all other branches have received EOS.
  bool note_end(GstPad* pad, GstEventType type) {
    if (type == GST_EVENT_STREAM_START) forget_end(pad);
    if (type != GST_EVENT_EOS) return false;
    std::lock_guard lock(ended_mutex_);
    ended_.push_back(pad);
    return !GST_PAD_IS_EOS(source_) && !any_other_sink(pad, [this](GstPad* other) {
      return std::find(ended_.begin(), ended_.end(), other) == ended_.end();
    });
  }

  Status check_caps(GstPad* pad, GstCaps* caps) const {
    Ref<GstCaps> different;
    Ref<GstPad> where;
    any_other_sink(pad, [&](GstPad* other) {
      auto theirs = Ref<GstCaps>::adopt(gst_pad_get_current_caps(other));
      if (!theirs || gst_caps_is_equal(theirs.get(), caps)) return false;
      different = std::move(theirs);
      where = Ref<GstPad>::share(other);
      return true;
    });
    if (!different) return ok();
    const gst::UniqueText came{gst_caps_to_string(caps)},
        needed{gst_caps_to_string(different.get())};
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the branches of join have different caps",
        .offered = std::string(came.get()) + " on " + GST_OBJECT_NAME(pad),
        .needed = std::string(needed.get()) + ", as on " + GST_OBJECT_NAME(where.get()),
        .fix = "put \"" + std::string(needed.get()) + "\" after a converter in each branch"};
  }

  GstPad* source_ = nullptr;  // owned by the element
  std::atomic<uint32_t> next_pad_{0};
  Output output_;
  std::string stream_id_;                // last sent; used by the thread that holds the output
  std::atomic<uint64_t> waits_{0};       // waits at the end of the active branch so far
  std::mutex markers_mutex_;             // guards markers_; taken last
  std::map<GstPad*, uint64_t> markers_;  // the last wait whose marker arrived at each branch
  std::mutex ended_mutex_;               // guards ended_, threads_ and own_threads_
  std::vector<GstPad*> ended_;           // branches that received EOS; addresses only
  std::map<GstPad*, std::thread::id> threads_;  // the thread that feeds each branch with a stream
  std::set<GstPad*> own_threads_;               // branches whose buffers come from other threads
};

}  // namespace

bool register_join(GstPlugin* plugin) {
  return Join::register_in(plugin);
}

}  // namespace weir
