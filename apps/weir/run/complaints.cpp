// Formats the parts of bus messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/complaints.hpp"

#include <algorithm>
#include <cstdio>

#include "colour.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

void print_complaint(const char* kind, Colour colour, const Complaint& complaint) {
  std::string head = kind;
  if (!complaint.element.empty()) head += " from " + complaint.element;
  // Other elements put text of peers and files into their errors as it is.
  std::string text = coloured(stderr, colour, printable_text(head)) + ": " +
                     (complaint.id.empty() ? "" : complaint.id + ": ") +
                     printable_text(complaint.what) + "\n";
  const auto add = [&text](const char* name, const std::string& part) {
    if (!part.empty()) text += std::string("  ") + name + ": " + printable_text(part) + "\n";
  };
  add("offered", complaint.offered);
  add("needed", complaint.needed);
  add("first difference", complaint.difference);
  if (!complaint.fix.empty())
    text += coloured(stderr, Colour::Green, "  fix: " + printable_text(complaint.fix)) + "\n";
  // Weir's errors are complete without it; GStreamer's own elements put the useful part there.
  if (complaint.id.empty()) add("details", complaint.debug);
  std::fputs(text.c_str(), stderr);
}

}  // namespace

void print_warning(const Complaint& warning) {
  print_complaint("warning", Colour::Yellow, warning);
}

// If one of Weir's elements reports the cause, the errors of others only follow from it. A source
// that retries, such as with other caps, repeats the same error.
void print_errors(const std::vector<Complaint>& errors) {
  const auto ours = [](const Complaint& complaint) { return !complaint.id.empty(); };
  const bool any_ours = std::any_of(errors.begin(), errors.end(), ours);
  for (auto error = errors.begin(); error != errors.end(); ++error)
    if ((!any_ours || ours(*error)) && std::find(errors.begin(), error, *error) == error)
      print_complaint("error", Colour::Red, *error);
}

}  // namespace weir::app
