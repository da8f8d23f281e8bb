// The subcommands of `weir`. Each returns the exit status of the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace weir::app {

inline constexpr int kExitGood = 0;
inline constexpr int kExitError = 1;
inline constexpr int kExitUsage = 2;          // invalid command line
inline constexpr int kExitInterrupted = 130;  // as shells report an exit by Ctrl-C

// Reports what is installed, where, and what is missing. kExitError when GStreamer does not find
// Weir.
struct DoctorOptions {
  bool all = false;  // each element, setting, folder and file
  bool json = false;
};
int doctor(const DoctorOptions& options);

// Prints the page of an error code, "WEIR-2001" or "2001"; without one the list of codes.
int explain(const std::string& code);

// Values of the tensor_filter properties of these names, for models that do not declare their
// tensors.
struct TensorOptions {
  std::string input, inputtype, inputname, output, outputtype, outputname;
  // The names and values of the members that are not empty.
  std::vector<std::pair<std::string, std::string>> pairs() const {
    std::vector<std::pair<std::string, std::string>> out;
    const std::pair<const char*, const std::string&> all[]{
        {"input", input},   {"inputtype", inputtype},   {"inputname", inputname},
        {"output", output}, {"outputtype", outputtype}, {"outputname", outputname}};
    for (const auto& [name, value] : all)
      if (!value.empty()) out.emplace_back(name, value);
    return out;
  }
};

struct InspectOptions {
  std::string model;      // a path; comma-separated for several files; "": only the engine
  std::string framework;  // "" or "auto": by the file name
  std::string custom;     // options of the engine
  TensorOptions tensors;
  bool json = false;
};
int inspect(const InspectOptions& options);

enum class ModelsAction { List, Info, Get };
struct ModelsOptions {
  ModelsAction action = ModelsAction::List;
  std::string name;  // of Info and Get
  bool json = false;
};
// Shows the catalogue of public models, or one of them, or fetches it.
int models(const ModelsOptions& options);

struct TryOptions {
  std::string model;   // a path, or a name of the catalogue
  std::string input;   // a photo, a video, a camera, an address, or "test"
  std::string output;  // a file for the picture with results; "": none
  std::string labels;  // path of a label file; "": those of the card or the model
  std::string mode;    // of tensor_decoder; "": chosen
  std::string head;    // of the mode; "": recognised
  std::string engine;  // "": by the file name
  bool json = false, show = false;
};
// Runs the model on the input; prints results, and the pipeline on standard error.
int try_model_on_input(const TryOptions& options);

struct PkiOptions {
  int days = 0;                             // that the certificate is valid
  std::string folder = ".";                 // of the authority
  std::string name{};                       // of issue: subject and first name of the certificate
  std::vector<std::string> alternatives{};  // of issue: more host names and addresses
  bool json = false;
};
// Makes a certificate authority in a folder.
int pki_init(const PkiOptions& options);
// Makes a certificate and its key, signed by the authority of the folder.
int pki_issue(const PkiOptions& options);

struct ServeOptions {
  bool model_control = false;
  std::vector<std::string> models;  // "MODEL" or "NAME=MODEL"
  std::string listen = "127.0.0.1:8001";
  std::string tls_cert, tls_key, tls_ca, token_file;  // paths; "": none
  bool insecure = false;                              // allows other machines without TLS
  std::string engine;                                 // "": by the file name
  std::string custom;                                 // options of the engine
  unsigned batch = 1, workers = 1;                    // as of tensor_filter
  unsigned batch_wait_us = 2000;  // that a request waits for others of its batch
  std::string metrics;            // address of the page of metrics; "": none
  // Limits, with the meaning that they have for tensor_query_serversrc; 0 = no limit.
  std::optional<unsigned> max_connections, max_connections_of_address;
  bool dry_run = false;  // prints the pipelines only
};
// Serves models to clients until a signal ends it.
int serve(const ServeOptions& options);

struct CardOptions {
  std::string model;   // a path
  std::string engine;  // "": by the file name
  std::string output;  // "" or "-": standard output
};
// Writes what the model's file says of its inputs and outputs as a card, with what `weir try`
// assumes, and a "?" for what is not known. Never replaces a file.
int write_card(const CardOptions& options);

struct EvaluateOptions {
  std::string model;                 // a path, a name of the catalogue, or a pipeline
  std::string folder;                // pictures with truth
  std::string compare;               // a second model or pipeline; "": none
  std::string truth;                 // path of an annotation file of COCO; "": found in the folder
  std::string metric;                // "": by the folder
  std::string labels, mode, head;    // of models, as in TryOptions
  std::string engine;                // of models; "": by the file name
  std::vector<std::string> classes;  // labels of the objects to follow; empty: all
  std::string page;                  // path of an HTML page; "": none
  uint64_t limit = 0;                // pictures at most, of each sequence; 0: all
  uint64_t draws = 1000, seed = 1;   // of the bootstrap
  bool json = false;
};
// Compares the results of the model, or of two, with the truth and prints scores.
int evaluate(const EvaluateOptions& options);

struct BenchOptions {
  std::string model;                 // a path; comma-separated for several files
  std::vector<std::string> engines;  // empty: all that accept the model
  std::vector<int> threads;          // empty: 1, 2, 4 ... up to the number of cores
  std::vector<int> batches;          // empty: 1 and 4
  std::string custom;                // options of the engine; "": its defaults and choices
  TensorOptions tensors;
  std::string card;      // path of a card; "": the model's own
  double seconds = 1;    // measuring time per case
  double timeout = 120;  // seconds for everything else in a round of a case
  bool json = false;
};
// Measures every engine, thread count and batch size that the model supports and prints the fastest
// pipeline. kExitError when none works.
int bench(const BenchOptions& options);

// Runs one case of bench() in a child process and writes the result to `descriptor` as JSON.
struct BenchCaseOptions {
  std::string model, engine, custom;
  TensorOptions tensors;
  int threads = 1, batch = 1, descriptor = 1;
  double seconds = 1, timeout = 120;
};
int bench_case(const BenchCaseOptions& options);

struct RunOptions {
  std::vector<std::string>
      pipeline;  // as for gst-launch-1.0: one argument, or several as split by a shell
  bool json = false;
  bool verbose = false;   // print each property that changes, such as caps
  bool quiet = false;     // print warnings and errors only
  double time_limit = 0;  // seconds until the stream is ended; 0 = none
  std::string report;     // path of an HTML report; "" for none
  std::string clock;      // address of a clock that other machines share; "" = the pipeline's own
  int serving_port = -1;  // serves the clock to other machines; 0 = a free port, -1 = it does not
};
int run(const RunOptions& options);
// Like run(), and reports to the service manager that the pipeline plays, stops and lives
// (ServiceNotifier).
int run_as_service(const RunOptions& options);

struct NewModuleOptions {
  std::string kind;      // "filter", "engine", "decoder", "converter"
  std::string language;  // of a filter: "c", "c++", "python", "lua"; the others are in C++
  std::string name;      // of the filter, engine, ... and of the new folder
};
// Writes a folder with a source, a build, a README and a test.
int new_module(const NewModuleOptions& options);

// A custom filter for NNStreamer's interface, in C: writes nnstreamer_customfilter_BASE.c and .mk
// to the current folder.
struct CustomClassOptions {
  std::string name;        // a C identifier
  std::string base;        // "": same as `name`
  bool fixed = true;       // the tensors have fixed sizes; otherwise they follow the stream
  bool allocates = false;  // invoke allocates the outputs
};
int new_custom_class(const CustomClassOptions& options);
// Prompts for these options on standard output, reads standard input, and writes the files.
int ask_for_filter();

// Prints configuration and sub-plugins in the format of nnstreamer-check. kExitError when GStreamer
// does not find Weir.
int check();

struct PbtxtOptions {
  std::vector<std::string> pipeline;  // one argument or several; empty: standard input
  bool from_pbtxt = false, verbose = false;
};
// Converts the pipeline to a graph in MediaPipe's text format. The elements need not be installed.
int pbtxt(const PbtxtOptions& options);

}  // namespace weir::app
