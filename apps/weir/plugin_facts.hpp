// What GStreamer knows of Weir's plug-in and of plug-ins that stand in its way.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace weir::app {

struct ElementFact {
  std::string name;
  std::string plugin;  // the plug-in that GStreamer takes it from
  std::string file;
};

struct ConflictFact {
  std::string plugin;
  std::string file;
  std::string reason;
  std::string fix;
};

struct PluginFacts {
  std::string gstreamer;  // its version
  bool found = false;
  std::string file, version;
  std::string load_error;             // found, but it cannot be loaded: why
  std::vector<ElementFact> elements;  // of Weir, or with a name as Weir's have
  std::vector<ConflictFact> conflicts;
  std::vector<std::string> searched;  // folders
};

// Needs gst_init.
PluginFacts plugin_facts();

}  // namespace weir::app
