// Fuzz target: plays random pipelines of Weir's elements, with random properties, in this process.
// What they get is damaged: sizes, numbers of memories and times that do not fit the caps, caps and
// properties that change, flushes, gaps and changes of state. Every pipeline must end, every frame
// must be counted, and GLib must not report a critical message.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "adding_filter.hpp"
#include "core/tensor/tensor_header.hpp"
#include "fuzz_input.hpp"
#include "memory_file.hpp"
#include "pipeline_pools.hpp"
#include "weir/custom_filter.h"

// Defined by GST_PLUGIN_DEFINE in src/plugin/plugin.cpp.
G_BEGIN_DECLS
GST_PLUGIN_STATIC_DECLARE(weir);
G_END_DECLS

namespace {

using weir::fuzz::FuzzInput;
using weir::fuzz::Header;
using weir::fuzz::kElements;
using weir::fuzz::kFormats;
using weir::fuzz::kLeftAlone;
using weir::fuzz::require;
using weir::fuzz::SourceFormat;

constexpr GstClockTime kMaxWait = 10 * GST_SECOND;

int copy(const weir_host*, const weir_frame* in, weir_frame* out, void*, weir_error*) {
  std::memcpy(out->tensors[0].data, in->tensors[0].data, in->tensors[0].bytes);
  return WEIR_OK;
}
int drop(const weir_host*, const weir_frame*, weir_frame*, void*, weir_error*) {
  return WEIR_NO_RESULT;
}
int fail(const weir_host* host, const weir_frame*, weir_frame*, void*, weir_error* error) {
  return host->fail(error, WEIR_ENGINE_UNKNOWN, "as ordered", "a", "b", "c", "d");
}

void register_filter(const char* name, weir_filter_invoke invoke) {
  weir_tensor_info info{};
  info.type = WEIR_UINT8;
  info.rank = 1;
  info.shape[0] = 4;
  weir_filter filter{};
  filter.struct_size = sizeof filter;
  filter.n_inputs = filter.n_outputs = 1;
  filter.inputs = filter.outputs = &info;
  filter.invoke = invoke;
  require(weir_filter_register(name, &filter, nullptr) == WEIR_OK, "the filter is registered");
}

// Prints what is played if the environment variable FUZZ_TRACE is set.
__attribute__((format(printf, 1, 2))) void trace(const char* format, ...) {
  static const bool wanted = std::getenv("FUZZ_TRACE") != nullptr;
  if (!wanted) return;
  va_list values;
  va_start(values, format);
  std::vfprintf(stderr, format, values);
  va_end(values);
  std::fputc('\n', stderr);
}

class Player {
 public:
  explicit Player(FuzzInput* input) : input_(*input), pipeline_(gst_pipeline_new(nullptr)) {
    build();
  }
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;
  ~Player() {
    gst_element_set_state(pipeline_, GST_STATE_NULL);
    gst_object_unref(pipeline_);
  }

  void play() {
    set_state(GST_STATE_PLAYING);
    for (int i = 0; i < 48 && !input_.empty() && !failed_; ++i) act();
    set_state(GST_STATE_PLAYING);
    if (failed_) return;
    for (Source& source : sources_) {
      // GStreamer reports caps that the peer rejects only when a buffer follows them.
      push(&source);
      gst_app_src_end_of_stream(GST_APP_SRC(source.element));
    }
    const bool ended = wait_for_end();
    for (GstElement* element : elements_)
      if (ended) wait_until_counted(element);
    // It ends the threads, and the counters stay until the next start.
    gst_element_set_state(pipeline_, GST_STATE_READY);
    for (GstElement* element : elements_) check_ledger(element);
  }

 private:
  struct Source {
    GstElement* element;
    GstPad* pad;  // of the element
    const SourceFormat* format = nullptr;
    GstClockTime pts = 0;
  };

  template <size_t N>
  const char* one_of(const char* const (&all)[N]) {
    return all[input_.below(N)];
  }

  GstElement* add(const char* description) {
    GstElement* element = gst_parse_launch(description, nullptr);
    require(element, "the element exists");
    trace("%s is %s", GST_OBJECT_NAME(element), description);
    gst_bin_add(GST_BIN(pipeline_), element);
    return element;
  }

  void build() {
    for (uint32_t i = 1 + input_.below(4); i > 0; --i) {
      const std::string_view description = one_of(kElements);
      GstElement* element = add(description.data());
      elements_.push_back(element);
      prepare(element);
      if (input_.below(4) == 0) set_property(element);
      g_signal_connect(element, "pad-added", G_CALLBACK(end_branch), pipeline_);
      g_signal_connect(element, "pad-removed", G_CALLBACK(remove_end), pipeline_);
      link_sinks(element, description);
      collect_sources(element);
    }
    for (GstPad* pad : std::exchange(open_, {})) {
      end_branch(nullptr, pad, pipeline_);
      gst_object_unref(pad);
    }
    for (Source& source : sources_) choose_caps(&source);
  }

  static void prepare(GstElement* element) {
    static const weir::fuzz::MemoryFile zones(
        R"({"version":1,"zones":[{"name":"gate","line":[[0,4],[8,4]]}]})");
    const auto set = [element](const char* name, const char* value) {
      if (g_object_class_find_property(G_OBJECT_GET_CLASS(element), name))
        gst_util_set_object_arg(G_OBJECT(element), name, value);
    };
    set("max-buffer-size", "16777216");
    set("zones", zones.path().c_str());
    // A sink that starts later would let the state of the pipeline change on another thread, while
    // this one changes it.
    set("async", "false");
  }

  // Ends a branch with a sink, when the pad is still free.
  static void end_branch(GstElement*, GstPad* pad, GstElement* pipeline) {
    if (GST_PAD_DIRECTION(pad) != GST_PAD_SRC || gst_pad_is_linked(pad) || !GST_STATE(pipeline))
      return;
    GstElement* sink = gst_element_factory_make("fakesink", nullptr);
    g_object_set(sink, "async", FALSE, "sync", FALSE, nullptr);
    gst_bin_add(GST_BIN(pipeline), sink);
    GstPad* target = gst_element_get_static_pad(sink, "sink");
    trace("  %s:%s ends at %s", GST_DEBUG_PAD_NAME(pad), GST_OBJECT_NAME(sink));
    gst_pad_link(pad, target);
    gst_object_unref(target);
    g_object_set_qdata_full(G_OBJECT(pad), end_quark(), gst_object_ref(sink), gst_object_unref);
    gst_element_sync_state_with_parent(sink);
  }
  // A sink without a stream would never end, and the pipeline neither.
  static void remove_end(GstElement*, GstPad* pad, GstElement* pipeline) {
    auto* sink = static_cast<GstElement*>(g_object_steal_qdata(G_OBJECT(pad), end_quark()));
    if (!sink) return;
    if (GST_OBJECT_PARENT(sink) == GST_OBJECT(pipeline)) gst_bin_remove(GST_BIN(pipeline), sink);
    gst_element_set_state(sink, GST_STATE_NULL);
    gst_object_unref(sink);
  }
  static GQuark end_quark() { return g_quark_from_static_string("fuzz-end"); }

  // Links every sink pad that the element has or that it gives: to an open pad, else to a source.
  void link_sinks(GstElement* element, std::string_view description) {
    // Without regions=pad the second pad of this one is an error.
    const bool single = description.starts_with("tensor_preprocess") &&
                        description.find("regions=pad") == std::string_view::npos;
    const bool has_always_pad = element->numsinkpads > 0;
    for (const GList* i = gst_element_class_get_pad_template_list(GST_ELEMENT_GET_CLASS(element));
         i; i = i->next) {
      auto* pad_template = static_cast<GstPadTemplate*>(i->data);
      if (pad_template->direction != GST_PAD_SINK) continue;
      if (pad_template->presence == GST_PAD_ALWAYS) {
        feed(gst_element_get_static_pad(element, pad_template->name_template));
      } else if (!single || input_.rarely()) {
        for (uint32_t n = 1 + (has_always_pad ? 0 : input_.below(3)); n > 0; --n)
          feed(gst_element_request_pad(element, pad_template, nullptr, nullptr));
      }
    }
  }
  void feed(GstPad* sink) {
    if (!sink) return;
    if (!open_.empty() && !input_.rarely()) {
      const size_t which = input_.below(static_cast<uint32_t>(open_.size()));
      GstPad* source = open_[which];
      if (gst_pad_link(source, sink) == GST_PAD_LINK_OK) {
        trace("  %s:%s feeds %s:%s", GST_DEBUG_PAD_NAME(source), GST_DEBUG_PAD_NAME(sink));
        open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(which));
        gst_object_unref(source);
        gst_object_unref(sink);
        return;
      }
    }
    GstElement* element = add("appsrc");
    g_object_set(element, "format", GST_FORMAT_TIME, "max-bytes", guint64{0}, "stream-type",
                 GST_APP_STREAM_TYPE_SEEKABLE, nullptr);
    g_signal_connect(element, "seek-data", G_CALLBACK(+[] { return TRUE; }), nullptr);
    GstPad* source = gst_element_get_static_pad(element, "src");
    gst_pad_link(source, sink);
    trace("  %s feeds %s:%s", GST_OBJECT_NAME(element), GST_DEBUG_PAD_NAME(sink));
    sources_.push_back({.element = element, .pad = source});
    gst_object_unref(source);
    gst_object_unref(sink);
  }
  void collect_sources(GstElement* element) {
    for (const GList* i = gst_element_class_get_pad_template_list(GST_ELEMENT_GET_CLASS(element));
         i; i = i->next) {
      auto* pad_template = static_cast<GstPadTemplate*>(i->data);
      if (pad_template->direction != GST_PAD_SRC) continue;
      if (pad_template->presence == GST_PAD_ALWAYS) {
        open_.push_back(gst_element_get_static_pad(element, pad_template->name_template));
      } else if (pad_template->presence == GST_PAD_REQUEST) {
        for (uint32_t n = 1 + input_.below(2); n > 0; --n)
          if (GstPad* pad = gst_element_request_pad(element, pad_template, nullptr, nullptr))
            open_.push_back(pad);
      }
    }
  }

  // Chooses caps that the peer accepts, but not always.
  void choose_caps(Source* source) {
    const uint32_t first = input_.below(std::size(kFormats));
    source->format = &kFormats[first];
    if (!input_.rarely()) {
      GstCaps* accepted = gst_pad_peer_query_caps(source->pad, nullptr);
      for (size_t i = 0; i < std::size(kFormats); ++i) {
        const SourceFormat& format = kFormats[(first + i) % std::size(kFormats)];
        if (!fits(format, accepted)) continue;
        source->format = &format;
        break;
      }
      gst_caps_unref(accepted);
    }
    GstCaps* caps = gst_caps_from_string(source->format->caps);
    trace("  %s sends %s", GST_OBJECT_NAME(source->element), source->format->caps);
    gst_app_src_set_caps(GST_APP_SRC(source->element), caps);
    gst_caps_unref(caps);
  }
  static bool fits(const SourceFormat& format, GstCaps* accepted) {
    GstCaps* caps = gst_caps_from_string(format.caps);
    const bool fit = gst_caps_can_intersect(caps, accepted);
    gst_caps_unref(caps);
    return fit;
  }

  void set_property(GstElement* element) {
    guint count = 0;
    GParamSpec** all = g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count);
    GParamSpec* spec = all[input_.byte() % count];
    g_free(all);
    if (!(spec->flags & G_PARAM_WRITABLE) || (spec->flags & G_PARAM_CONSTRUCT_ONLY)) return;
    if (std::ranges::count(kLeftAlone, std::string_view(spec->name))) return;
    const std::string chosen = value(spec);
    trace("  %s %s=%s", GST_OBJECT_NAME(element), spec->name, chosen.c_str());
    gst_util_set_object_arg(G_OBJECT(element), spec->name, chosen.c_str());
  }
  std::string value(GParamSpec* spec) {
    if (G_IS_PARAM_SPEC_ENUM(spec)) {
      const GEnumClass* values = G_PARAM_SPEC_ENUM(spec)->enum_class;
      return values->values[input_.byte() % values->n_values].value_nick;
    }
    if (G_IS_PARAM_SPEC_STRING(spec)) return text();
    if (G_IS_PARAM_SPEC_BOOLEAN(spec)) return input_.flag() ? "true" : "false";
    return one_of(weir::fuzz::kNumbers);
  }
  std::string text() {
    if (input_.below(8)) return one_of(weir::fuzz::kTexts);
    std::string out(input_.line().substr(0, 64));
    // No file is opened by chance.
    std::erase_if(out, [](char c) { return c == '\0' || c == '/'; });
    return g_utf8_validate(out.data(), static_cast<gssize>(out.size()), nullptr) ? out : "";
  }

  void set_state(GstState state) {
    trace("  state %s", gst_element_state_get_name(state));
    if (gst_element_set_state(pipeline_, state) != GST_STATE_CHANGE_FAILURE) return;
    failed_ = true;
    trace_message(next_message(GST_MESSAGE_ERROR, 0));
  }

  void act() {
    if (!sources_.empty() && input_.below(8) > 1) {
      push(&sources_[input_.below(static_cast<uint32_t>(sources_.size()))]);
      return;
    }
    switch (input_.below(8)) {
      case 0:
        return set_state(GST_STATE_PAUSED);
      case 1:
        return set_state(GST_STATE_PLAYING);
      case 2:
        return set_state(GST_STATE_READY);
      case 3:
        return set_property(elements_[input_.below(static_cast<uint32_t>(elements_.size()))]);
      case 4:
        return query();
      default:
        if (!sources_.empty())
          send_event(&sources_[input_.below(static_cast<uint32_t>(sources_.size()))]);
    }
  }

  void push(Source* source) {
    GstBuffer* buffer = gst_buffer_new();
    for (const size_t bytes : source->format->bytes) {
      const bool first = gst_buffer_n_memory(buffer) == 0;
      if (bytes == 0 && !first) break;
      std::vector<guint8> memory;
      if (source->format->header != Header::None)
        memory = chunk(source->format->header);
      else
        memory.resize(bytes == 0 ? input_.byte() : bytes);
      fill(std::span(memory).subspan(header_bytes(memory, *source->format)));
      append(buffer, std::move(memory));
    }
    stamp(source, buffer);
    trace("  %s sends %zu bytes, pts %" GST_TIME_FORMAT, GST_OBJECT_NAME(source->element),
          gst_buffer_get_size(buffer), GST_TIME_ARGS(GST_BUFFER_PTS(buffer)));
    gst_app_src_push_buffer(GST_APP_SRC(source->element), buffer);
  }
  static size_t header_bytes(const std::vector<guint8>& memory, const SourceFormat& format) {
    return format.header == Header::None ? 0 : std::min(memory.size(), weir::kTensorHeaderBytes);
  }
  // A tensor with its header, of a flexible or sparse stream.
  std::vector<guint8> chunk(Header kind) {
    using weir::ElementType;
    const weir::TensorSpec specs[] = {{ElementType::UInt8, {4}, ""},
                                      {ElementType::UInt32, {4, 1 + input_.below(3)}, ""},
                                      {ElementType::Float32, {6, 1 + input_.below(3)}, ""},
                                      {ElementType::UInt8, {3, 8, 8}, ""}};
    weir::TensorHeader header;
    header.spec = specs[input_.below(std::size(specs))];
    header.format = kind == Header::Sparse ? weir::Format::Sparse : weir::Format::Flexible;
    if (kind == Header::Sparse) header.nonzero_count = input_.below(4);
    std::vector<guint8> out(weir::kTensorHeaderBytes + header.payload_bytes().value_or(0));
    weir::write_tensor_header(
        header, std::as_writable_bytes(std::span(out)).first<weir::kTensorHeaderBytes>());
    return out;
  }
  void fill(std::span<guint8> out) {
    const bool numbers = input_.flag();
    const auto bytes = input_.bytes(std::min<size_t>(out.size(), 4 + input_.below(20)));
    for (size_t i = 0; i < out.size() && !bytes.empty(); ++i)
      out[i] = static_cast<guint8>(bytes[i % bytes.size()]);
    // As floats, random bytes are rarely small numbers.
    if (!numbers) return;
    for (size_t i = 0; i + sizeof(float) <= out.size(); i += sizeof(float)) {
      const float number = static_cast<float>(out[i]) / 16;
      std::memcpy(&out[i], &number, sizeof number);
    }
  }
  // Changes the size, and cuts it in several memories, but not often.
  void append(GstBuffer* buffer, std::vector<guint8> bytes) {
    if (input_.rarely()) bytes.resize(input_.byte());
    if (input_.rarely() && !bytes.empty()) bytes[input_.byte() % bytes.size()] ^= 1 + input_.byte();
    size_t done = 0;
    for (uint32_t n = 1 + (input_.rarely() ? input_.below(20) : 0); n > 0; --n) {
      const size_t left = bytes.size() - done;
      const size_t part = n == 1 ? left : input_.byte() % (left + 1);
      GstMemory* memory = gst_allocator_alloc(nullptr, part, nullptr);
      GstMapInfo map;
      require(gst_memory_map(memory, &map, GST_MAP_WRITE), "the memory can be written");
      if (part > 0) std::memcpy(map.data, bytes.data() + done, part);
      gst_memory_unmap(memory, &map);
      gst_buffer_append_memory(buffer, memory);
      done += part;
    }
  }
  void stamp(Source* source, GstBuffer* buffer) {
    constexpr GstClockTime kStep = 33 * GST_MSECOND;
    source->pts += kStep;
    GST_BUFFER_PTS(buffer) = source->pts;
    GST_BUFFER_DURATION(buffer) = kStep;
    if (!input_.rarely()) return;
    constexpr GstClockTime kTimes[] = {0, GST_CLOCK_TIME_NONE, GST_CLOCK_TIME_NONE - 1, 1,
                                       G_MAXINT64};
    GST_BUFFER_PTS(buffer) = kTimes[input_.below(std::size(kTimes))];
    GST_BUFFER_DTS(buffer) = kTimes[input_.below(std::size(kTimes))];
    GST_BUFFER_DURATION(buffer) = kTimes[input_.below(std::size(kTimes))];
    if (input_.flag()) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_GAP | GST_BUFFER_FLAG_DISCONT);
  }

  void query() {
    trace("  queries");
    gint64 value = 0;
    (void)gst_element_query_position(pipeline_, GST_FORMAT_TIME, &value);
    GstQuery* latency = gst_query_new_latency();
    (void)gst_element_query(pipeline_, latency);
    gst_query_unref(latency);
    for (GstElement* element : elements_) {
      gst_element_foreach_pad(
          element,
          [](GstElement*, GstPad* pad, gpointer) -> gboolean {
            GstCaps* caps = gst_pad_query_caps(pad, nullptr);
            gst_caps_unref(caps);
            return TRUE;
          },
          nullptr);
    }
  }

  void send_event(Source* source) {
    const uint32_t kind = input_.below(6);
    trace("  event %u at %s", kind, GST_OBJECT_NAME(source->element));
    switch (kind) {
      case 0:
        gst_element_send_event(source->element,
                               gst_event_new_seek(1.0, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH,
                                                  GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_NONE, -1));
        break;
      case 1:
        choose_caps(source);
        break;
      case 2:
        gst_pad_push_event(source->pad, gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_OOB,
                                                             gst_structure_new_empty("fuzz")));
        break;
      case 3:
        gst_element_send_event(source->element, gst_event_new_tag(gst_tag_list_new_empty()));
        break;
      case 4:
        gst_pad_send_event(source->pad, gst_event_new_reconfigure());
        break;
      default:
        for (GstElement* element : elements_)
          gst_element_send_event(element,
                                 gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 2.0, 1000, source->pts));
    }
  }

  GstMessage* next_message(int types, GstClockTime wait) {
    GstBus* bus = gst_element_get_bus(pipeline_);
    GstMessage* message = gst_bus_timed_pop_filtered(bus, wait, static_cast<GstMessageType>(types));
    gst_object_unref(bus);
    return message;
  }
  // Frees the message.
  static void trace_message(GstMessage* message) {
    if (!message) return;
    GError* error = nullptr;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
      gst_message_parse_error(message, &error, nullptr);
    trace("  %s from %s: %s", GST_MESSAGE_TYPE_NAME(message), GST_MESSAGE_SRC_NAME(message),
          error ? error->message : "");
    g_clear_error(&error);
    gst_message_unref(message);
  }

  // Whether EOS came; false after an error. Only sinks post EOS.
  bool wait_for_end() {
    GstMessage* message = next_message(GST_MESSAGE_EOS | GST_MESSAGE_ERROR, kMaxWait);
    require(message, "the pipeline ends");
    const bool ended = GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS;
    trace_message(message);
    return ended;
  }

  struct Counts {
    guint64 received = 0, consumed = 0, dropped = 0;
    bool complete() const { return received == consumed + dropped; }
  };
  static Counts counts_of(GstElement* element) {
    Counts out;
    if (!g_object_class_find_property(G_OBJECT_GET_CLASS(element), "stats")) return out;
    GstStructure* stats = nullptr;
    g_object_get(element, "stats", &stats, nullptr);
    gst_structure_get_uint64(stats, "received", &out.received);
    gst_structure_get_uint64(stats, "consumed", &out.consumed);
    gst_structure_get_uint64(stats, "dropped", &out.dropped);
    gst_structure_free(stats);
    require(out.received >= out.consumed + out.dropped, "no frame is counted twice");
    return out;
  }
  // The sinks may be done before an element is: it has ended its output, or has none.
  static void wait_until_counted(GstElement* element) {
    const gint64 limit = g_get_monotonic_time() + static_cast<gint64>(kMaxWait / 1000);
    while (!counts_of(element).complete()) {
      require(g_get_monotonic_time() < limit, "no frame is held after the end");
      g_usleep(1000);
    }
  }
  static void check_ledger(GstElement* element) {
    const Counts counts = counts_of(element);
    trace("  %s: %" G_GUINT64_FORMAT " frames, %" G_GUINT64_FORMAT " consumed, %" G_GUINT64_FORMAT
          " dropped",
          GST_OBJECT_NAME(element), counts.received, counts.consumed, counts.dropped);
    require(counts.complete(), "every frame is counted");
  }

  FuzzInput& input_;
  GstElement* pipeline_;
  std::vector<GstElement*> elements_;
  std::vector<Source> sources_;
  std::vector<GstPad*> open_;  // owned
  bool failed_ = false;
};

void initialise() {
  gst_init(nullptr, nullptr);
  g_log_set_always_fatal(static_cast<GLogLevelFlags>(G_LOG_LEVEL_CRITICAL | G_LOG_LEVEL_ERROR));
  GST_PLUGIN_STATIC_REGISTER(weir);
  weir::fuzz::register_adding_filter();
  register_filter("same", copy);
  register_filter("nothing", drop);
  register_filter("failing", fail);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  [[maybe_unused]] static const bool initialised = (initialise(), true);
  FuzzInput input(data, size);
  Player(&input).play();
  return 0;
}
