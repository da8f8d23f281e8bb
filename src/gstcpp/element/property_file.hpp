// The property config-file: a text file that sets properties of an element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <mutex>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::gst {

// Sets each property that the file names (docs/compatibility/filter.md 4.1): bool is true for
// "true" in any case, else false; numbers use their leading digits; strings are used as they are.
// Skips unknown keys, read-only properties, unknown enum values and config-file itself;
// `warnings` (may be null) gets a warning for each but the last. `object` is an element.
// FILE_NOT_FOUND when the file cannot be read.
Status set_properties_from_file(GObject* object, const std::string& path,
                                std::vector<Error>* warnings = nullptr);

// FILE_NOT_FOUND when the file cannot be read. ok() for "", which names none.
Status check_property_file(const std::string& path);

// The result of an element's config-file: read when the property is set, reported when the element
// starts, because an element under construction has no bus. Thread-safe.
class PropertyFile {
 public:
  // Sets the properties from `path`; "" clears the previous result. Posts warnings on an element
  // that has started already.
  void read(GObject* object, const std::string& path);
  // Posts the warnings of the last read() on `element`. FILE_NOT_FOUND when it could not be read.
  Status report(GstElement* element) const;

 private:
  mutable std::mutex mutex_;  // guards the rest
  Status status_ = ok();
  std::vector<Error> warnings_;
};

}  // namespace weir::gst
