// The properties of tensor_filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <string_view>
#include <tuple>

#include "core/filter/layout_list.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "elements/tensor_filter/model_report.hpp"
#include "gstcpp/element/live_settings.hpp"
#include "gstcpp/element/property.hpp"

namespace weir::gst {

template <>
struct EnumType<WhenBusyChoice> {
  static GType type() {
    static constexpr GEnumValue kValues[] = {
        {static_cast<int>(WhenBusyChoice::Unset),
         "As block; one worker runs on the streaming thread", "unset"},
        {static_cast<int>(WhenBusyChoice::Block),
         "Block the streaming thread until a worker is free", "block"},
        {static_cast<int>(WhenBusyChoice::DropNew), "Drop the new frame", "drop-new"},
        {static_cast<int>(WhenBusyChoice::DropOld),
         "Keep the newest frame and drop the one that was waiting", "drop-old"},
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
        {static_cast<int>(IsolateChoice::Process), "In a separate process for each worker",
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
         "Drop the frame and start a new process; drop frames until it runs", "restart"},
        {static_cast<int>(isolate::OnCrash::Drop),
         "Drop the frame and all later ones until the element is restarted", "drop"},
        {static_cast<int>(isolate::OnCrash::Error), "Post an error, which ends the pipeline",
         "error"},
        {static_cast<int>(isolate::OnCrash::Wait),
         "Drop the frame and start a new process; later frames wait for it", "wait"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirFilterOnCrash", kValues);
    return t;
  }
};

}  // namespace weir::gst

namespace weir {

// What a property says about the model, besides its value.
struct FilterFlags {
  bool reopens = false;   // a change, also while frames flow, opens the model again
  bool repeated = false;  // decides the result of a frame: part of the command that replays one
};
template <class P>
struct Flagged : P {
  FilterFlags flags;
};
template <class P>
Flagged(P, FilterFlags) -> Flagged<P>;

inline constexpr FilterFlags kReopens{.reopens = true}, kRepeated{.repeated = true},
    kReopensRepeated{.reopens = true, .repeated = true};
inline constexpr auto kPlaying = gst::Changeable::WhilePlaying;

inline constexpr std::tuple kFilterProperties{
    gst::Property{"silent", &FilterSettings::silent, "Accepted for compatibility; has no effect",
                  kPlaying},
    Flagged{gst::Accessor{"framework", &FilterSettings::framework, &ModelReport::framework,
                          "Name of the engine; auto = selected by the extension of the model file",
                          kPlaying},
            kReopensRepeated},
    Flagged{gst::Property{
                "model", &FilterSettings::model,
                "Path of the model file, or a comma list of several; is-updatable allows changes "
                "while playing",
                kPlaying},
            kRepeated},
    gst::Property{"fallback", &FilterSettings::fallback,
                  "Path of a local model that answers a frame if the server is unavailable, late "
                  "or refuses it; its file extension selects the engine; empty = none"},
    Flagged{gst::Property{"custom", &FilterSettings::custom,
                          "Options of the engine: key:value,key:value", kPlaying},
            kReopensRepeated},
    Flagged{
        gst::Property{
            "accelerator", &FilterSettings::accelerator,
            "Hardware to use: (true|false)[:NAME,...] with npu, gpu, cpu, ...; !NAME excludes one",
            kPlaying},
        kReopensRepeated},
    Flagged{
        gst::Accessor{"input", &FilterSettings::input,
                      &ModelReport::reported<&FilterSettings::input, true, dimensions_text>,
                      "Dimensions of the model's inputs, if the model leaves them open", kPlaying},
        kReopensRepeated},
    Flagged{gst::Accessor{"inputtype", &FilterSettings::inputtype,
                          &ModelReport::reported<&FilterSettings::inputtype, true, types_text>,
                          "Element types of the model's inputs", kPlaying},
            kReopensRepeated},
    Flagged{gst::Accessor{"inputname", &FilterSettings::inputname,
                          &ModelReport::reported_names<&FilterSettings::inputname, true>,
                          "Names of the model's inputs", kPlaying},
            kReopensRepeated},
    Flagged{gst::Accessor{"inputlayout", &FilterSettings::inputlayout,
                          &ModelReport::reported_layouts<&FilterSettings::inputlayout, true>,
                          "NCHW, NHWC, ANY or NONE for each input", kPlaying},
            kReopens},
    gst::ReadOnly{"inputranks", &ModelReport::reported_ranks<true>, "Ranks of the model's inputs"},
    Flagged{gst::Accessor{"output", &FilterSettings::output,
                          &ModelReport::reported<&FilterSettings::output, false, dimensions_text>,
                          "Dimensions of the model's outputs", kPlaying},
            kReopensRepeated},
    Flagged{gst::Accessor{"outputtype", &FilterSettings::outputtype,
                          &ModelReport::reported<&FilterSettings::outputtype, false, types_text>,
                          "Element types of the model's outputs", kPlaying},
            kReopensRepeated},
    Flagged{gst::Accessor{"outputname", &FilterSettings::outputname,
                          &ModelReport::reported_names<&FilterSettings::outputname, false>,
                          "Names of the model's outputs", kPlaying},
            kReopensRepeated},
    Flagged{gst::Accessor{"outputlayout", &FilterSettings::outputlayout,
                          &ModelReport::reported_layouts<&FilterSettings::outputlayout, false>,
                          "NCHW, NHWC, ANY or NONE for each output", kPlaying},
            kReopens},
    gst::ReadOnly{"outputranks", &ModelReport::reported_ranks<false>,
                  "Ranks of the model's outputs"},
    Flagged{gst::Property{"input-combination", &FilterSettings::input_combination,
                          "Comma list of the stream's tensors to use as model inputs", kPlaying},
            kReopens},
    Flagged{gst::Property{"output-combination", &FilterSettings::output_combination,
                          "Comma list of i<N> (input tensor) and o<N> (model output) to push",
                          kPlaying},
            kReopens},
    gst::Property{"is-updatable", &FilterSettings::is_updatable,
                  "Allow another model to replace the current one while playing", kPlaying},
    Flagged{
        gst::Property{"shared-tensor-filter-key", &FilterSettings::shared_tensor_filter_key,
                      "Filters of this process with the same key and model share one open model",
                      kPlaying},
        kReopens},
    gst::Property{"config-file", &FilterSettings::config_file,
                  "File with lines of property=value, read when this is set", kPlaying},
    Flagged{
        gst::Property{"suspend", &FilterSettings::suspend,
                      "Milliseconds without a buffer after which the model is suspended; 0 = never",
                      kPlaying, 0u, std::numeric_limits<uint32_t>::max()},
        kReopens},
    Flagged{
        gst::Property{"invoke-dynamic", &FilterSettings::invoke_dynamic,
                      "Outputs are flexible tensors, and the model may change their size with each "
                      "frame",
                      kPlaying},
        kReopens},
    Flagged{gst::Property{
                "invoke-async", &FilterSettings::invoke_async,
                "The engine answers on its own threads, with any number of outputs for a frame",
                kPlaying},
            kReopens},
    gst::Property{"async-timeout", &FilterSettings::async_timeout,
                  "With invoke-async: maximum time in milliseconds without an answer from the "
                  "engine while frames are in progress; 0 = no limit"},
    gst::Property{"invoke-rows", &FilterSettings::invoke_rows,
                  "Maximum number of rows of a frame's batch (its outermost dimension) in one "
                  "invoke; 0 = all",
                  gst::Changeable::InReady, 0u, 1u << 20},
    gst::Property{
        "invoke-threads", &FilterSettings::invoke_threads,
        "Parts of a frame's batch that run at the same time, each on its own thread and session",
        gst::Changeable::InReady, 1u, 64u},
    gst::Property{"qos", &FilterSettings::qos, "Drop frames that are too late for the sink",
                  kPlaying},
    gst::Property{"batch-size", &FilterSettings::batch_size,
                  "Frames that are collected into one invoke, from this filter and those that "
                  "share its model; 1 = no batching",
                  gst::Changeable::InReady, uint32_t{1}, uint32_t{1024}},
    gst::Property{
        "batch-timeout", &FilterSettings::batch_timeout,
        "Maximum time in nanoseconds that a frame waits for others before an incomplete batch runs",
        gst::Changeable::InReady, uint64_t{0}, uint64_t{INT64_MAX}},
    gst::Property{"workers", &FilterSettings::workers,
                  "Frames that are processed at the same time, each on its own thread and session; "
                  "they are pushed in order; 1 = as many as the engine asks for",
                  gst::Changeable::InReady, 1u, 64u},
    gst::Property{"threads", &FilterSettings::threads,
                  "Engine threads for each worker; 0 = a part of the cores; NumThreads in custom "
                  "takes precedence",
                  gst::Changeable::InReady, 0, 1024},
    gst::Property{"when-busy", &FilterSettings::when_busy,
                  "What to do with a frame that arrives while every worker is busy"},
    gst::Property{"max-bytes", &FilterSettings::max_bytes,
                  "Maximum bytes of input frames that wait or are in progress, and with "
                  "invoke-async of waiting outputs; at the limit when-busy decides; 0 = no limit"},
    gst::Property{"isolate", &FilterSettings::isolate,
                  "Where the engine runs; in a separate process it cannot harm this one"},
    Flagged{gst::Property{
                "isolate-memory", &FilterSettings::isolate_memory,
                "With isolate=process: maximum private memory of a process in MiB; 0 = no limit",
                gst::Changeable::InReady, 0u, 1u << 24},
            kRepeated},
    Flagged{gst::Property{
                "isolate-timeout", &FilterSettings::isolate_timeout,
                "With isolate=process: time limit of an invoke in milliseconds; the start (at "
                "least a minute) and the first invoke may take ten times as long; 0 = no limit"},
            kRepeated},
    gst::Property{"on-crash", &FilterSettings::on_crash,
                  "With isolate=process: what to do when a process ends or times out"},
    gst::Property{"crash-folder", &FilterSettings::crash_folder,
                  "With isolate=process: folder in which frames that end a process are saved; "
                  "empty = they are not saved"},
    gst::Property{"deadline", &FilterSettings::deadline,
                  "Nanoseconds after its running time at which a frame becomes useless: it is "
                  "dropped instead of being processed later; 0 = never",
                  kPlaying, uint64_t{0}, uint64_t{INT64_MAX}},
    gst::Property{"latency-report", &FilterSettings::latency_report,
                  "Add the time of an invoke to the latency of the pipeline, and post a message "
                  "when it changes",
                  kPlaying},
    gst::ReadOnly{"sub-plugins", &ModelReport::sub_plugins, "Installed engines"},
    gst::Gauge{"latency", &FilterSettings::latency, &ModelReport::latency,
               "Write 1 to enable; reads as the mean of the last 10 invokes in microseconds", 0, 1},
    gst::Gauge{"throughput", &FilterSettings::throughput, &ModelReport::throughput,
               "Write 1 to enable; reads as outputs per second x 1000", 0, 1},
};

// Calls `f` with each property that has flags.
template <class F>
void each_flagged(F&& f) {
  gst::each_setting(kFilterProperties, [&](const auto& p, size_t) {
    if constexpr (requires { p.flags; }) f(p);
  });
}
inline bool reopens_model(std::string_view name) {
  bool reopens = false;
  each_flagged([&](const auto& p) { reopens = reopens || (p.flags.reopens && name == p.name); });
  return reopens;
}

}  // namespace weir
