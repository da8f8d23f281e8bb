// The properties of tensor_filter whose values the user sets.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <tuple>

#include "elements/tensor_filter/filter_settings.hpp"
#include "gstcpp/property.hpp"

namespace weir::gst {

template <>
struct EnumType<WhenBusyChoice> {
  static GType type() {
    static constexpr GEnumValue kValues[] = {
        {static_cast<int>(WhenBusyChoice::Unset),
         "As block; with one worker, on the thread that brings the frames", "unset"},
        {static_cast<int>(WhenBusyChoice::Block), "It waits, and so does whoever brings it",
         "block"},
        {static_cast<int>(WhenBusyChoice::DropNew), "It is dropped", "drop-new"},
        {static_cast<int>(WhenBusyChoice::DropOld),
         "It waits, and what waited in its place is dropped", "drop-old"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirFilterWhenBusy", kValues);
    return t;
  }
};

template <>
struct EnumType<IsolateChoice> {
  static GType type() {
    static constexpr GEnumValue kValues[] = {
        {static_cast<int>(IsolateChoice::None), "In this process", "none"},
        {static_cast<int>(IsolateChoice::Process), "In a process of its own for each worker",
         "process"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirFilterIsolate", kValues);
    return t;
  }
};

template <>
struct EnumType<isolate::OnCrash> {
  static GType type() {
    static constexpr GEnumValue kValues[] = {
        {static_cast<int>(isolate::OnCrash::Restart),
         "The frame is dropped, and a new process started; frames until then are dropped",
         "restart"},
        {static_cast<int>(isolate::OnCrash::Drop),
         "The frame is dropped, and every one after it until the element is started again", "drop"},
        {static_cast<int>(isolate::OnCrash::Error), "An error ends the pipeline", "error"},
        {static_cast<int>(isolate::OnCrash::Wait),
         "The frame is dropped, and a new process started; frames until then wait for it", "wait"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirFilterOnCrash", kValues);
    return t;
  }
};

}  // namespace weir::gst

namespace weir {

inline constexpr std::tuple kFilterProperties{
    gst::Property{"silent", &FilterSettings::silent, "Accepted for compatibility; has no effect",
                  gst::Changeable::WhilePlaying},
    gst::Property{"model", &FilterSettings::model,
                  "Path of the model file; several: comma list. While playing: see is-updatable",
                  gst::Changeable::WhilePlaying},
    gst::Property{"custom", &FilterSettings::custom, "Options of the engine: key:value,key:value",
                  gst::Changeable::WhilePlaying},
    gst::Property{"input-combination", &FilterSettings::input_combination,
                  "Comma list of the stream's tensors that the model gets",
                  gst::Changeable::WhilePlaying},
    gst::Property{"output-combination", &FilterSettings::output_combination,
                  "Comma list of i<N> (input tensor) and o<N> (model output) to push",
                  gst::Changeable::WhilePlaying},
    gst::Property{"accelerator", &FilterSettings::accelerator,
                  "(true|false)[:NAME,...] of npu, gpu, cpu, ...; !NAME leaves one out",
                  gst::Changeable::WhilePlaying},
    gst::Property{"is-updatable", &FilterSettings::is_updatable,
                  "Another model may take the place of the one that runs, while playing",
                  gst::Changeable::WhilePlaying},
    gst::Property{"shared-tensor-filter-key", &FilterSettings::shared_tensor_filter_key,
                  "Filters of this process with one key and one model open it once",
                  gst::Changeable::WhilePlaying},
    gst::Property{"config-file", &FilterSettings::config_file,
                  "File with lines of property=value, read when this is set",
                  gst::Changeable::WhilePlaying},
    gst::Property{"suspend", &FilterSettings::suspend,
                  "Milliseconds without a buffer after which the model is put to sleep; 0 = never",
                  gst::Changeable::WhilePlaying, 0u, std::numeric_limits<uint32_t>::max()},
    gst::Property{"invoke-dynamic", &FilterSettings::invoke_dynamic,
                  "Outputs are flexible tensors, and the model may change their size with each "
                  "frame",
                  gst::Changeable::WhilePlaying},
    gst::Property{"invoke-async", &FilterSettings::invoke_async,
                  "The engine answers on its own threads, with any number of outputs for a frame"},
    gst::Property{"async-timeout", &FilterSettings::async_timeout,
                  "With invoke-async: milliseconds that the engine may say nothing while frames "
                  "are in work; 0 = any"},
    gst::Property{"invoke-rows", &FilterSettings::invoke_rows,
                  "Rows of a frame's batch (its outermost dimension) that go into one invoke at "
                  "most; 0 = all",
                  gst::Changeable::InReady, 0u, 1u << 20},
    gst::Property{
        "invoke-threads", &FilterSettings::invoke_threads,
        "Parts of a frame's batch that are run at once, each on a thread and a session of "
        "its own",
        gst::Changeable::InReady, 1u, 64u},
    gst::Property{"qos", &FilterSettings::qos, "Drop frames that are too late for the sink",
                  gst::Changeable::WhilePlaying},
    gst::Property{
        "batch-size", &FilterSettings::batch_size,
        "Frames that are gathered into one invoke, of this filter and of those that share "
        "its model; 1 = none are",
        gst::Changeable::InReady, uint32_t{1}, uint32_t{1024}},
    gst::Property{"batch-timeout", &FilterSettings::batch_timeout,
                  "Nanoseconds that a frame waits for others at most, before a batch that is not "
                  "full goes",
                  gst::Changeable::InReady, uint64_t{0}, uint64_t{INT64_MAX}},
    gst::Property{"workers", &FilterSettings::workers,
                  "Frames that are in work at once, each on a thread and a session of its own; "
                  "they leave in their order",
                  gst::Changeable::InReady, 1u, 64u},
    gst::Property{"threads", &FilterSettings::threads,
                  "Threads of the engine for each worker; 0 = a share of the cores. NumThreads in "
                  "custom wins",
                  gst::Changeable::InReady, 0, 1024},
    gst::Property{"when-busy", &FilterSettings::when_busy,
                  "What becomes of a frame that comes while every worker is busy"},
    gst::Property{
        "max-bytes", &FilterSettings::max_bytes,
        "Bytes of input frames that wait or are in work, and with invoke-async of outputs "
        "that wait; at the bound when-busy decides; 0 = any"},
    gst::Property{"isolate", &FilterSettings::isolate,
                  "Where the engine runs: what it does to its own process cannot reach this one"},
    gst::Property{"isolate-timeout", &FilterSettings::isolate_timeout,
                  "With isolate=process: milliseconds for an invoke, ten times as many for the "
                  "start (a minute at least) and the first one; 0 = any"},
    gst::Property{"isolate-memory", &FilterSettings::isolate_memory,
                  "With isolate=process: MiB of private memory that a process may have; 0 = any",
                  gst::Changeable::InReady, 0u, 1u << 24},
    gst::Property{"on-crash", &FilterSettings::on_crash,
                  "With isolate=process: what follows the end of a process or a time-out"},
    gst::Property{"crash-folder", &FilterSettings::crash_folder,
                  "With isolate=process: where frames that end a process are kept; empty = they "
                  "are not"},
    gst::Property{"deadline", &FilterSettings::deadline,
                  "Nanoseconds after its running time at which a frame is worthless: it is dropped "
                  "when it would begin later; 0 = never",
                  gst::Changeable::WhilePlaying, uint64_t{0}, uint64_t{INT64_MAX}},
    gst::Property{"latency-report", &FilterSettings::latency_report,
                  "Add the time of an invoke to the latency of the pipeline, and tell it when that "
                  "changes",
                  gst::Changeable::WhilePlaying},
};

}  // namespace weir
