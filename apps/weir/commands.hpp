// The subcommands of `weir`. Each returns the exit status of the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace weir::app {

inline constexpr int kExitGood = 0;
inline constexpr int kExitError = 1;
inline constexpr int kExitUsage = 2;          // the command line cannot be read
inline constexpr int kExitInterrupted = 130;  // as shells report an end by Ctrl-C

// What is installed, where, and what is missing. kExitError when GStreamer does not find Weir.
int doctor(bool json);

// What the properties of tensor_filter with these names say, for models that do not say it.
struct TensorWords {
  std::string input, inputtype, inputname, output, outputtype, outputname;
  // The names and values of those that are not empty.
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
  std::string model;      // a path; several with commas between them; "": the engine alone
  std::string framework;  // "" or "auto": by the name of the file
  std::string custom;     // options of the engine
  TensorWords words;
  bool json = false;
};
int inspect(const InspectOptions& options);

struct BenchOptions {
  std::string model;                 // a path; several with commas between them
  std::vector<std::string> engines;  // empty: all that take the model
  std::vector<int> threads;          // empty: 1, 2, 4 ... to the cores
  std::vector<int> batches;          // empty: 1 and 4
  std::string custom;                // options of the engine; "": its defaults, and its choices
  TensorWords words;
  std::string card;       // a file; "": the model's own
  double seconds = 1;     // of measuring, for each case
  double patience = 120;  // seconds for all else that a round of a case takes
  bool json = false;
};
// Every engine, thread count and batch that can take a model, and the fastest line. kExitError when
// none can.
int bench(const BenchOptions& options);

// One case of bench() in a process of its own: what came of it goes to `descriptor` as JSON.
struct BenchCaseOptions {
  std::string model, engine, custom;
  TensorWords words;
  int threads = 1, batch = 1, descriptor = 1;
  double seconds = 1, patience = 120;
};
int bench_case(const BenchCaseOptions& options);

struct RunOptions {
  std::vector<std::string>
      pipeline;  // as for gst-launch-1.0: one word, or many as a shell cut them
  bool json = false;
  std::string report;  // an HTML file to write at the end; "" for none
};
int run(const RunOptions& options);

struct NewFilterOptions {
  std::string language;  // "c", "c++", "python", "lua"
  std::string name;      // of the filter and of the folder that is made
};
int new_filter(const NewFilterOptions& options);

// A custom filter for NNStreamer's interface, in C: two files in the present folder,
// nnstreamer_customfilter_BASE.c and .mk.
struct CustomClassOptions {
  std::string name;        // an identifier in C
  std::string base;        // "": the name
  bool fixed = true;       // the tensors' sizes; else they follow the stream
  bool allocates = false;  // invoke allocates the outputs
};
int new_custom_class(const CustomClassOptions& options);
// Asks for them on standard output, reads answers from standard input, and writes the files.
int ask_for_filter();

// Configuration and sub-plugins in the lines of nnstreamer-check. kExitError when GStreamer does
// not find Weir.
int check();

struct PbtxtOptions {
  std::vector<std::string> pipeline;  // one word, or many; none: standard input
  bool from_pbtxt = false, verbose = false;
};
// The pipeline as a graph in MediaPipe's text format. Nothing of it need be installed.
int pbtxt(const PbtxtOptions& options);

}  // namespace weir::app
