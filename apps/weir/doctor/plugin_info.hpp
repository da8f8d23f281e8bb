// PluginInfo: what GStreamer knows about Weir's plug-in and about conflicting plug-ins.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace weir::app {

struct ElementInfo {
  std::string name;
  std::string plugin;  // the plug-in that provides it to GStreamer
  std::string file;
  unsigned rank = 0;  // GStreamer's rank; irrelevant for elements named in a pipeline
};

struct PluginConflict {
  std::string plugin;
  std::string file;
  std::string reason;
  std::string fix;
  std::string version = {};  // version of that plug-in; "" when unknown
};

struct PluginInfo {
  std::string gstreamer;  // version of GStreamer
  bool found = false;
  std::string file, version;
  std::string load_error;             // why the plug-in was found but cannot be loaded
  std::vector<ElementInfo> elements;  // elements of Weir, or with the names of Weir's
  std::vector<PluginConflict> conflicts;
  std::vector<std::string> searched;  // folders
  std::string yields_to;  // origin of the setting prefer_nnstreamer: file and line, or variable; ""
                          // when not set
};

// Needs gst_init.
PluginInfo get_plugin_info();

}  // namespace weir::app
