// The property config-file: a text file that sets properties of an element.
#pragma once
#include <gst/gst.h>

#include <mutex>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir::gst {

// Sets each property that the file names (specification 4.1): bool by "true" in any case, else
// false; numbers by their leading digits; texts as they are. Unknown keys, properties that cannot
// be written, words that an enum does not have and config-file itself are passed over;
// `passed_over` (may be null) gets a warning for each but the last. `object` is an element.
// FILE_NOT_FOUND when the file cannot be read.
Status set_properties_from_file(GObject* object, const std::string& path,
                                std::vector<Error>* passed_over = nullptr);

// What came of an element's property config-file: read when it is set, told when the element
// starts, for an element that is being made has no bus. Thread-safe.
class PropertyFile {
 public:
  // Sets the properties of `path`; "" forgets what was read before.
  void read(GObject* object, const std::string& path);
  // Posts the warnings of the last read() on `element`. FILE_NOT_FOUND when it could not be read.
  Status report(GstElement* element) const;

 private:
  mutable std::mutex mutex_;  // guards the rest
  Status status_ = ok();
  std::vector<Error> passed_over_;
};

}  // namespace weir::gst
