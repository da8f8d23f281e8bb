// PipelineDescription: a pipeline of a command, as elements and values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::app {

// Names and values, in the order in which they are set.
using Properties = std::vector<std::pair<std::string, std::string>>;

// Values come from the command line, from model cards and from file names, and may contain
// anything. make() sets them as properties after GStreamer has parsed the rest, so that no value
// can become an element.
//
//   PipelineDescription out;
//   out.element("filesrc", {{"location", path}}).text(" ! decodebin ! fakesink");
class PipelineDescription {
 public:
  // Appends a part of a pipeline. It comes from Weir, or is a pipeline that the user wrote; a shell
  // has read its quotes.
  PipelineDescription& text(std::string_view part);
  // Appends an element. Without a property `name`, it gets the name of its factory and a number,
  // which no element in a text() may have. A name that is set consists of letters, digits and ._-
  PipelineDescription& element(std::string factory, Properties properties = {});
  PipelineDescription& append(const PipelineDescription& other);

  // Writes the pipeline for users, who can paste it after gst-launch-1.0 into a shell.
  std::string pasted() const;
  // Makes a GstPipeline in state NULL. The errors of read_pipeline(); OPTION_VALUE for a property
  // that an element does not have and for a value that it cannot have.
  Result<gst::Ref<GstElement>> make() const;

 private:
  struct Part {
    std::string text;     // without an element
    std::string factory;  // "": the part is text
    Properties properties;
  };
  // Returns the name of the element that is part `index`.
  std::string get_name(size_t index) const;

  std::vector<Part> parts_;
};

}  // namespace weir::app
