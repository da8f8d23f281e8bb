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
  unsigned rank = 0;  // of GStreamer; plays no part for elements that a text names
};

struct ConflictFact {
  std::string plugin;
  std::string file;
  std::string reason;
  std::string fix;
  std::string version = {};  // of that plug-in; "" where it is not known
};

struct PluginFacts {
  std::string gstreamer;  // its version
  bool found = false;
  std::string file, version;
  std::string load_error;             // found, but it cannot be loaded: why
  std::vector<ElementFact> elements;  // of Weir, or with a name as Weir's have
  std::vector<ConflictFact> conflicts;
  std::vector<std::string> searched;  // folders
  std::string gives_way;  // the file and line, or variable, that says it; "": it does not
};

// Needs gst_init.
PluginFacts plugin_facts();

}  // namespace weir::app
