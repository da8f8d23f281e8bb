// The command `weir`: parses the command line and runs a subcommand.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "core/config/install_paths.hpp"
#include "core/process/process_object.hpp"
#include "library/process.h"
#include "usage.hpp"

namespace weir::app {
namespace {

// The options of `weir pbtxt`, which is nnstreamer-parser too.
void add_pbtxt(CLI::App* command, PbtxtOptions* pbtxt) {
  command->add_flag("--from-pbtxt,-p", pbtxt->from_pbtxt, "The other direction; not implemented");
  command->add_flag("--verbose,-v", pbtxt->verbose, "Print elements and links on standard error");
  command->positionals_at_end();
  command->add_option("PIPELINE", pbtxt->pipeline, "The pipeline; default: read from stdin");
}

// Runs the command that `name` stands for and returns its exit status; nullopt: a name of Weir's.
std::optional<int> by_another_name(const std::string& name, int argc, char** argv) {
  if (name != "nnstreamer-check" && name != "nnstreamer-parser" &&
      name != "nnstreamerCodeGenCustomFilter")
    return std::nullopt;
  CLI::App app{"Weir's command " + name, name};
  PbtxtOptions options;
  if (name == "nnstreamer-parser") add_pbtxt(&app, &options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitGood : kExitUsage;
  }
  if (name == "nnstreamer-parser") return pbtxt(options);
  if (name == "nnstreamerCodeGenCustomFilter") return ask_for_filter();
  gst_init(nullptr, nullptr);
  return check();
}

constexpr const char* kModelOrName = "A model file, or a name from weir models list";
constexpr int kAuthorityDays = 3650, kCertificateDays = 90;

struct CommandLine {
  BenchOptions bench;
  BenchCaseOptions bench_case;
  InspectOptions inspect;
  ModelsOptions models;
  TryOptions attempt;
  EvaluateOptions evaluation;
  RunOptions run;
  PkiOptions authority{.days = kAuthorityDays}, certificate{.days = kCertificateDays};
  ServeOptions server;
  NewModuleOptions made;
  bool is_service = false;
  CustomClassOptions custom_class;
  CardOptions card;
  bool any_size = false;
  PbtxtOptions pbtxt;
  DoctorOptions doctor;
  std::string error_code;
  std::vector<std::string> help_topic;
};

void add_tensor_options(CLI::App* command, TensorOptions* tensors) {
  const std::pair<const char*, std::string*> options[]{
      {"--input", &tensors->input},           {"--inputtype", &tensors->inputtype},
      {"--inputname", &tensors->inputname},   {"--output", &tensors->output},
      {"--outputtype", &tensors->outputtype}, {"--outputname", &tensors->outputname}};
  for (const auto& [name, text] : options)
    command
        ->add_option(name, *text,
                     "Like the property of tensor_filter, for models that leave it open")
        ->type_name("LIST");
}

// The same option for all commands that open a model.
CLI::Option* add_engine(CLI::App* command, std::string* engine) {
  return command
      ->add_option("--engine,-e", *engine, "The engine; default: selected by the file's extension")
      ->type_name("NAME");
}

void add_bench(CLI::App* app, BenchOptions* bench) {
  constexpr int kMaxThreads = 1024, kMaxBatch = 1024;
  constexpr double kMinSeconds = 0.01, kMaxSeconds = 3600;
  auto* command =
      app->add_subcommand("bench", "Measure a model with each engine, thread count and batch size");
  command->add_option("MODEL", bench->model, kModelOrName)->required();
  command->add_option("--engine,-e", bench->engines, "Use only these engines, separated by commas")
      ->delimiter(',');
  command
      ->add_option("--threads,-t", bench->threads,
                   "Thread counts; default: 1, 2, 4 up to the number of cores")
      ->delimiter(',')
      ->check(in_range(1, kMaxThreads));
  command->add_option("--batch,-b", bench->batches, "Batch sizes; default: 1 and 4")
      ->delimiter(',')
      ->check(in_range(1, kMaxBatch));
  command->add_option("--custom", bench->custom, "Options of the engine, as in custom=");
  add_tensor_options(command, &bench->tensors);
  command
      ->add_option("--card", bench->card,
                   "The model card for the printed line; default: the model's card")
      ->type_name("FILE");
  command->add_option("--seconds", bench->seconds, "Seconds to measure each case; default: 1")
      ->check(in_range(kMinSeconds, kMaxSeconds));
  command->add_option("--timeout", bench->timeout, "Seconds to load and warm up; default: 120")
      ->check(in_range(1.0, kMaxSeconds));
  command->add_flag("--json", bench->json, "Print JSON");
}

// The hidden command that `bench` starts for each case.
void add_bench_case(CLI::App* app, BenchCaseOptions* one) {
  auto* command = app->add_subcommand("bench-case", "")->group("");
  command->add_option("MODEL", one->model)->required();
  command->add_option("--engine", one->engine)->required();
  command->add_option("--custom", one->custom);
  command->add_option("--threads", one->threads);
  command->add_option("--batch", one->batch);
  command->add_option("--seconds", one->seconds);
  command->add_option("--descriptor", one->descriptor);
  add_tensor_options(command, &one->tensors);
}

void add_try(CLI::App* app, TryOptions* options) {
  auto* command = app->add_subcommand(
      "try", "Run a model on a photo, video, camera or stream and show the results");
  command->add_option("MODEL", options->model, kModelOrName)->required();
  command
      ->add_option("INPUT", options->input,
                   "A photo or video, /dev/video0, rtsp://..., or test for a test picture")
      ->required();
  command->add_flag("--json", options->json, "Print a JSON object for each frame");
  command
      ->add_option("--output,-o", options->output,
                   "Write the input with the results drawn on it: .jpg, .png, .webm, .mkv, .avi")
      ->type_name("FILE");
  command->add_flag("--show", options->show, "Show the results in a window");
  command->add_option("--labels", options->labels, "File with class names, one on each line")
      ->type_name("FILE");
  command->add_option(
      "--mode", options->mode,
      "detection, classification, segmentation, pose, depth or text; default: by card or outputs");
  command->add_option("--head", options->head, "The head of docs/heads.md; default: recognised");
  add_engine(command, &options->engine);
}

void add_evaluate(CLI::App* app, EvaluateOptions* options) {
  constexpr uint64_t kMaxDraws = 1'000'000;
  auto* command = app->add_subcommand(
      "evaluate", "Measure the accuracy of a model or pipeline on a labelled folder");
  command
      ->add_option(
          "MODEL", options->model,
          "A model file, a name from weir models list, or a pipeline from pictures to results")
      ->required();
  command
      ->add_option(
          "FOLDER", options->folder,
          "Pictures with ground truth: COCO, a folder for each class, images and masks, MOT")
      ->required();
  command->add_option("--compare", options->compare, "A second model or pipeline")
      ->type_name("MODEL");
  command
      ->add_option("--metric", options->metric,
                   "ap, oks, accuracy, iou or tracking; default: selected by the folder")
      ->check(CLI::IsMember({"ap", "oks", "accuracy", "iou", "tracking"}));
  command->add_option("--truth", options->truth, "The annotation file; default: the only one")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "Print JSON");
  command->add_option("--page", options->page, "Write an HTML page with the worst pictures")
      ->type_name("FILE");
  command
      ->add_option("--labels", options->labels,
                   "File with the model's class names, one on each line")
      ->type_name("FILE");
  command->add_option("--mode", options->mode, "How to read the outputs, as for weir try");
  command->add_option("--head", options->head, "The head of docs/heads.md; default: recognised");
  add_engine(command, &options->engine);
  command
      ->add_option("--classes", options->classes,
                   "Labels of the objects to track, for MOT; default: all")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--limit", options->limit, "Use the first N pictures; default: all")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  command->add_option("--draws", options->draws, "Draws for the intervals; default: 1000, 0: none")
      ->type_name("N")
      ->check(in_range(uint64_t{0}, kMaxDraws));
  command->add_option("--seed", options->seed, "Seed of the draws; default: 1")->type_name("N");
}

void add_models(CLI::App* app, ModelsOptions* models) {
  auto* command = app->add_subcommand("models", "List, show and download public models");
  command->require_subcommand(1);
  const auto add = [&](const char* name, const char* help, ModelsAction action) {
    auto* one = command->add_subcommand(name, help);
    one->add_flag("--json", models->json, "Print JSON");
    if (action != ModelsAction::List)
      one->add_option("NAME", models->name, "A name from the list")->required();
    one->callback([models, action] { models->action = action; });
  };
  add("list", "List the models: name, task, size, licence", ModelsAction::List);
  add("info", "Show where a model comes from, its digest, card and command", ModelsAction::Info);
  add("get", "Download a model and check its digest", ModelsAction::Get);
}

void add_pki(CLI::App* app, PkiOptions* authority, PkiOptions* certificate) {
  constexpr int kMaxDays = 36500;
  auto* command = app->add_subcommand("pki", "Make a certificate authority and certificates");
  command->require_subcommand(1);
  auto* init = command->add_subcommand("init", "Make a certificate authority in a folder");
  init->add_option("DIR", authority->folder, "The folder; created if it does not exist")
      ->required();
  init->add_option("--days", authority->days, "Days until it expires; default: 3650")
      ->check(in_range(1, kMaxDays));
  init->add_flag("--json", authority->json, "Print JSON");
  auto* issue = command->add_subcommand("issue", "Make a certificate for a server or client");
  issue->add_option("NAME", certificate->name, "Host name or address of the server, or any name")
      ->required();
  issue
      ->add_option("--dir", certificate->folder,
                   "Folder of the authority; default: the current one")
      ->type_name("DIR");
  issue->add_option("--san", certificate->alternatives, "More host names and addresses")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false);
  issue->add_option("--days", certificate->days, "Days until it expires; default: 90")
      ->check(in_range(1, kMaxDays));
  issue->add_flag("--json", certificate->json, "Print JSON");
}

void add_serve(CLI::App* app, ServeOptions* options) {
  constexpr unsigned kMaxBatch = 1024, kMaxWorkers = 1024, kMaxWait = 10'000'000;
  auto* command = app->add_subcommand("serve", "Serve models to clients on other machines");
  command
      ->add_option("MODEL", options->models,
                   "Model files, or names from weir models list, or NAME=MODEL")
      ->required();
  command
      ->add_option("--listen", options->listen,
                   "HOST:PORT or unix:PATH; default: 127.0.0.1:8001; port 0 uses a free port")
      ->type_name("ADDRESS");
  const std::tuple<const char*, std::string*, const char*> files[]{
      {"--tls-cert", &options->tls_cert, "The certificate of this server, in PEM"},
      {"--tls-key", &options->tls_key, "Its key"},
      {"--tls-ca", &options->tls_ca, "The authority that must sign the certificate of each client"},
      {"--token-file", &options->token_file,
       "File with tokens, one on each line; a client needs one"}};
  for (const auto& [name, path, help] : files)
    command->add_option(name, *path, help)->type_name("FILE");
  command->add_flag("--insecure", options->insecure,
                    "Let other machines connect without TLS, on a network that you trust");
  command->add_option("--batch", options->batch, "Run up to N requests in one invoke; default: 1")
      ->type_name("N")
      ->check(in_range(1u, kMaxBatch));
  command
      ->add_option("--batch-wait", options->batch_wait_us,
                   "Microseconds that a request waits for others; default: 2000")
      ->type_name("N")
      ->check(in_range(0u, kMaxWait));
  command->add_option("--workers", options->workers, "Sessions of each model; default: 1")
      ->type_name("N")
      ->check(in_range(1u, kMaxWorkers));
  command
      ->add_option("--max-connections", options->max_connections,
                   "Connections that have requests in progress; default: 32, 0: no limit")
      ->type_name("N");
  command
      ->add_option("--max-connections-per-address", options->max_connections_of_address,
                   "The same for each address; default: 4, 0: no limit")
      ->type_name("N");
  add_engine(command, &options->engine);
  command->add_option("--custom", options->custom, "Options of the engine, as in custom=");
  command->add_flag("--metrics{127.0.0.1:8002}", options->metrics,
                    "Serve metrics for Prometheus; --metrics=ADDRESS for another address");
  command->add_flag("--model-control", options->model_control,
                    "Let clients unload models and load them again");
  command->add_flag("--dry-run", options->dry_run, "Print the pipelines and serve nothing");
}

void add_inspect(CLI::App* app, InspectOptions* options) {
  auto* inspect =
      app->add_subcommand("inspect", "Show the inputs and outputs of a model, and how to run it");
  inspect->add_option(
      "MODEL", options->model,
      "A model file, or a name from weir models list; without it, show the engine of --engine");
  add_engine(inspect, &options->framework);
  // The former name.
  auto* former = inspect->add_option("--framework,-f", options->framework)->group("");
  former->excludes("--engine");
  inspect->add_option("--custom", options->custom, "Options of the engine, as in custom=");
  add_tensor_options(inspect, &options->tensors);
  inspect->add_flag("--json", options->json, "Print JSON");
  inspect->parse_complete_callback([inspect] {
    if (inspect->count("MODEL") + inspect->count("--engine") + inspect->count("--framework") == 0)
      throw CLI::RequiredError("MODEL or --engine");
  });
}

void add_card(CLI::App* app, CardOptions* card) {
  auto* command = app->add_subcommand("card", "Print a model card");
  command->add_option("MODEL", card->model, kModelOrName)->required();
  add_engine(command, &card->engine);
  command->add_option("--output,-o", card->output, "The new file; default: standard output")
      ->type_name("FILE");
}

void add_new(CLI::App* app, CommandLine* line) {
  auto* made = app->add_subcommand("new", "Create a filter, engine, decoder or converter");
  made->require_subcommand(1);
  auto* filter =
      made->add_subcommand("filter", "Create a folder with a filter that builds and runs");
  filter->add_option("--language,-l", line->made.language, "c, c++, python or lua")->required();
  filter->add_option("NAME", line->made.name, "Name of the filter and its folder")->required();
  const std::pair<const char*, const char*> modules[]{
      {"engine", "Create a folder with an engine in C++, which opens model files"},
      {"decoder", "Create a folder with a decoder in C++, a mode of tensor_decoder"},
      {"converter", "Create a folder with a converter in C++, for a new kind of stream"}};
  for (const auto& [kind, help] : modules)
    made->add_subcommand(kind, help)
        ->add_option("NAME", line->made.name, "Name of the module and its folder")
        ->required();
  auto* custom =
      made->add_subcommand("nnstreamer-filter", "Create a C source file with NNStreamer_custom");
  custom->add_option("--base,-b", line->custom_class.base, "Base name of the files; default: NAME");
  custom->add_flag("--any-size", line->any_size, "Sizes follow the stream (setInputDim)");
  custom->add_flag("--allocate", line->custom_class.allocates, "invoke allocates its outputs");
  custom->add_option("NAME", line->custom_class.name, "Name of the filter, a C identifier")
      ->required();
}

void add_run(CLI::App* app, RunOptions* options, bool* is_service) {
  constexpr double kMinSeconds = 0.001, kMaxSeconds = 1'000'000;
  auto* run = app->add_subcommand("run", "Run a pipeline in the syntax of gst-launch-1.0");
  run->add_flag("--json", options->json, "Print JSON at the end, and nothing else on stdout");
  run->add_option("--report", options->report,
                  "Write a page that shows what limits the pipeline; FILE.json: as JSON")
      ->type_name("FILE");
  run->add_flag("--verbose,-v", options->verbose,
                "Print the caps and each property that changes, on standard error");
  run->add_flag("--quiet,-q", options->quiet, "Print warnings and errors only")
      ->excludes("--verbose");
  run->add_flag("--service", *is_service,
                "Report to systemd that it plays, stops and is alive (Type=notify)");
  run->add_option("--timeout", options->time_limit, "End the stream after this many seconds")
      ->type_name("SECONDS")
      ->check(in_range(kMinSeconds, kMaxSeconds));
  run->add_option("--clock", options->clock,
                  "Use a network clock: net://HOST:PORT, ntp://HOST, ptp://DOMAIN")
      ->type_name("ADDRESS");
  run->add_option("--serve-clock", options->serving_port,
                  "Serve this pipeline's clock to other machines on a UDP port; 0 uses a free port")
      ->type_name("PORT")
      ->check(in_range(0, 65535));
  run->add_option("PIPELINE", options->pipeline, "The pipeline, as one argument or several")
      ->required();
}

void add_compatible_commands(CLI::App* app, CommandLine* line) {
  app->add_subcommand("check",
                      "Print configuration and sub-plugins in the format of nnstreamer-check");
  add_pbtxt(
      app->add_subcommand(
          "pbtxt", "Convert a pipeline to MediaPipe's text format; elements need not be installed"),
      &line->pbtxt);
}

// In the order of `weir help`: what a newcomer needs first.
void add_subcommands(CLI::App* app, CommandLine* line) {
  add_try(app, &line->attempt);
  add_run(app, &line->run, &line->is_service);
  add_inspect(app, &line->inspect);
  add_models(app, &line->models);
  auto* doctor = app->add_subcommand(
      "doctor", "Show what is installed, what is missing and how to install it");
  doctor->add_flag("--all", line->doctor.all, "Show each element, setting, folder and file");
  doctor->add_flag("--json", line->doctor.json, "Print JSON");
  app->add_subcommand("explain", "Show what an error code means and how to fix it")
      ->add_option("CODE", line->error_code, "Such as WEIR-2001; default: list all codes");
  add_bench(app, &line->bench);
  add_evaluate(app, &line->evaluation);
  add_serve(app, &line->server);
  add_card(app, &line->card);
  add_new(app, line);
  add_pki(app, &line->authority, &line->certificate);
  add_compatible_commands(app, line);
  add_bench_case(app, &line->bench_case);
  app->add_subcommand("help", "Show the commands, or the options of one")
      ->add_option("COMMAND", line->help_topic, "Such as run, or new filter");
}

int run_new(CLI::App* app, CommandLine* line) {
  line->made.kind = app->get_subcommands().front()->get_name();
  if (line->made.kind != "nnstreamer-filter") return new_module(line->made);
  line->custom_class.fixed = !line->any_size;
  return new_custom_class(line->custom_class);
}

int run_pki(CLI::App* app, const CommandLine& line) {
  return app->got_subcommand("init") ? pki_init(line.authority) : pki_issue(line.certificate);
}

// The subcommands that play pipelines.
int run_with_gstreamer(const CLI::App& app, const CommandLine& line) {
  gst_init(nullptr, nullptr);
  if (app.got_subcommand("evaluate")) return evaluate(line.evaluation);
  if (app.got_subcommand("try")) return try_model_on_input(line.attempt);
  if (app.got_subcommand("serve")) return serve(line.server);
  if (app.got_subcommand("check")) return check();
  if (app.got_subcommand("doctor")) return doctor(line.doctor);
  return line.is_service ? run_as_service(line.run) : run(line.run);
}

int run_subcommand(CLI::App* app, CommandLine* line) {
  if (app->got_subcommand("new")) return run_new(app->get_subcommand("new"), line);
  if (app->got_subcommand("help")) return show_help(*app, line->help_topic);
  if (app->got_subcommand("explain")) return explain(line->error_code);
  if (app->got_subcommand("pki")) return run_pki(app->get_subcommand("pki"), *line);
  if (app->got_subcommand("inspect")) return inspect(line->inspect);
  if (app->got_subcommand("card")) return write_card(line->card);
  if (app->got_subcommand("models")) return models(line->models);
  if (app->got_subcommand("bench")) return bench(line->bench);
  if (app->got_subcommand("bench-case")) return bench_case(line->bench_case);
  if (app->got_subcommand("pbtxt")) return pbtxt(line->pbtxt);
  return run_with_gstreamer(*app, *line);
}

int run_command(int argc, char** argv) {
  process::take_objects_from(weir_process_object);  // before the first use of such an object
  const std::string name = std::filesystem::path(argc > 0 ? argv[0] : "").filename();
  if (const auto status = by_another_name(name, argc, argv)) return *status;
  CLI::App app{"Weir: neural networks as elements of GStreamer pipelines", "weir"};
  CommandLine line;
  app.formatter(help_formatter());
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("weir ") + config::kVersion);
  add_subcommands(&app, &line);
  // After the commands, which would inherit it.
  app.footer("weir help COMMAND shows the options of a command, man weir-COMMAND its manual page.");
  if (argc > 1 && std::string_view(argv[1]) == kCompleteCommand)
    return print_completions(app, {argv + 2, argv + argc});
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (argc == 1) return show_help(app, {});
    if (error.get_exit_code() != 0) return report_usage_error(app, error);
    return app.exit(error);  // prints the help or the version that was asked for
  }
  return run_subcommand(&app, &line);
}

// Reports output that was lost, for example because the disk is full.
bool has_written_all() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return true;
  std::fputs("weir: standard output cannot be written; is the disk full?\n", stderr);
  return false;
}

}  // namespace
}  // namespace weir::app

int main(int argc, char** argv) {
  try {
    const int status = weir::app::run_command(argc, argv);
    return weir::app::has_written_all() ? status : weir::app::kExitError;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "weir: %s\n", error.what());
    return weir::app::kExitError;
  }
}
