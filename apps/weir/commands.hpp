// The subcommands of `weir`. Each returns the exit status of the process.
#pragma once
#include <string>
#include <vector>

namespace weir::app {

inline constexpr int kExitGood = 0;
inline constexpr int kExitError = 1;
inline constexpr int kExitUsage = 2;          // the command line cannot be read
inline constexpr int kExitInterrupted = 130;  // as shells report an end by Ctrl-C

// What is installed, where, and what is missing. kExitError when GStreamer does not find Weir.
int doctor(bool json);

struct InspectOptions {
  std::string model;      // a path; several with commas between them
  std::string framework;  // "" or "auto": by the name of the file
  bool json = false;
};
int inspect(const InspectOptions& options);

struct RunOptions {
  std::vector<std::string>
      pipeline;  // as for gst-launch-1.0: one word, or many as a shell cut them
  bool json = false;
  std::string report;  // an HTML file to write at the end; "" for none
};
int run(const RunOptions& options);

}  // namespace weir::app
