// The command `weir`: reads the command line and calls a subcommand.
#include <gst/gst.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "commands.hpp"

namespace weir::app {
namespace {

struct CommandLine {
  InspectOptions inspect;
  RunOptions run;
  bool doctor_json = false;
};

void add_subcommands(CLI::App* app, CommandLine* line) {
  auto* doctor =
      app->add_subcommand("doctor", "What is installed, what is missing, what brings it");
  doctor->add_flag("--json", line->doctor_json, "Print JSON");

  auto* inspect = app->add_subcommand("inspect", "What a model takes and gives, and how to run it");
  inspect->add_option("MODEL", line->inspect.model, "The model file")->required();
  inspect->add_option("--framework,-f", line->inspect.framework,
                      "The engine; else by the name of the file");
  inspect->add_flag("--json", line->inspect.json, "Print JSON");

  auto* run = app->add_subcommand("run", "Run a pipeline, written as for gst-launch-1.0");
  run->add_flag("--json", line->run.json, "Print JSON at the end, and nothing else on stdout");
  run->add_option("--report", line->run.report, "Write an HTML page: graph, times, queues, latency")
      ->type_name("FILE");
  // What comes behind the first word of the pipeline belongs to it, even --json.
  run->positionals_at_end();
  run->add_option("PIPELINE", line->run.pipeline, "The pipeline, as one word or many")->required();
}

}  // namespace
}  // namespace weir::app

int main(int argc, char** argv) {
  using namespace weir::app;
  CLI::App app{"Weir: neural networks as elements of GStreamer pipelines", "weir"};
  CommandLine line;
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("weir ") + WEIR_VERSION);
  app.footer("Manual pages: weir(1), weir-doctor(1), weir-inspect(1), weir-run(1)");
  add_subcommands(&app, &line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitGood : kExitUsage;
  }
  if (app.got_subcommand("inspect")) return inspect(line.inspect);
  gst_init(nullptr, nullptr);
  if (app.got_subcommand("doctor")) return doctor(line.doctor_json);
  return run(line.run);
}
