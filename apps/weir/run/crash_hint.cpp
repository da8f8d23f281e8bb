// The text is made beforehand: a signal handler may only write it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/crash_hint.hpp"

#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>

#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/property_text.hpp"
#include "launch/launch_tokens.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr std::array kSignals{SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

std::string hint;  // what the handler writes

void write_hint(int number) {
  const ssize_t ignored = ::write(STDERR_FILENO, hint.data(), hint.size());
  (void)ignored;
  raise(number);  // with its default action, which SA_RESETHAND has set
}

bool runs_in_this_process(GstElement* filter) {
  const GParamSpec* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(filter), "isolate");
  if (!spec) return false;
  gst::Value value(spec->value_type);
  g_object_get_property(G_OBJECT(filter), "isolate", value.get());
  const gst::UniqueText text(gst_value_serialize(value.get()));
  return text && std::strcmp(text.get(), "process") != 0;
}

std::vector<std::string> filters_in_this_process(GstElement* pipeline) {
  std::vector<std::string> out;
  for (const auto& element : gst::elements_in(pipeline))
    if (gst::get_factory_name(element.get()) == "tensor_filter" &&
        runs_in_this_process(element.get()))
      out.emplace_back(GST_OBJECT_NAME(element.get()));
  return out;
}

// The line with isolate=process at each tensor_filter without a value of isolate.
std::string with_isolation(const std::string& line) {
  constexpr std::string_view kFilter = "tensor_filter";
  const auto tokens = launch_tokens(line);
  if (!tokens) return line;
  std::string out;
  size_t copied = 0;
  for (size_t i = 0; i < tokens->size(); ++i) {
    if ((*tokens)[i].text != kFilter) continue;
    bool is_set = false;
    for (size_t p = i + 1; p < tokens->size() && (*tokens)[p].assigns; ++p)
      is_set = is_set || (*tokens)[p].text.starts_with("isolate=");
    if (is_set) continue;
    const size_t end = (*tokens)[i].at + kFilter.size();
    out += line.substr(copied, end - copied) + " isolate=process";
    copied = end;
  }
  return out + line.substr(copied);
}

}  // namespace

CrashHint::CrashHint(GstElement* pipeline, const std::string& line) {
  const auto filters = filters_in_this_process(pipeline);
  if (filters.empty()) return;
  hint = "\nerror: the process crashed, perhaps in the model or filter of " + join(filters, ", ") +
         "\n  needed: isolate=process, which runs the filter in its own process; the pipeline then "
         "survives a crash of the filter\n  fix: " +
         with_isolation(line) + "\n";
  struct sigaction action {};
  action.sa_handler = write_hint;
  action.sa_flags = SA_RESETHAND | SA_NODEFER;
  for (const int number : kSignals) {
    struct sigaction before {};
    if (sigaction(number, nullptr, &before) != 0 || before.sa_handler != SIG_DFL) continue;
    if (sigaction(number, &action, nullptr) == 0) signals_.push_back(number);
  }
}

CrashHint::~CrashHint() {
  for (const int number : signals_) std::signal(number, SIG_DFL);
}

}  // namespace weir::app
