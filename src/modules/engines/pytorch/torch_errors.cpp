// Extracts the reason from the texts of libtorch's exceptions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_errors.hpp"

#include <algorithm>

namespace weir::engine {
namespace {

bool contains(std::string_view text, std::string_view word) {
  return text.find(word) != std::string_view::npos;
}

std::string_view line_at(std::string_view text, size_t at) {
  return text.substr(at, std::min(text.find('\n', at), text.size()) - at);
}

std::string_view stripped(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\n')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\n')) text.remove_suffix(1);
  return text;
}

// Traces of the interpreter end in a line such as "RuntimeError: ..."; in other texts the first
// line has the reason.
std::string_view reason_line(std::string_view text) {
  for (size_t at = text.rfind("Error: "); at != std::string_view::npos && at > 0;
       at = text.rfind("Error: ", at - 1)) {
    const size_t start = text.rfind('\n', at) + 1;
    const auto word = text.substr(start, at - start);
    if (start > 0 && std::all_of(word.begin(), word.end(), [](char c) {
          return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '.';
        }))
      return line_at(text, start);
  }
  text = stripped(text);
  return line_at(text, 0);
}

// The call in the source line to which the trace points.
std::string_view failed_call(std::string_view text) {
  const size_t here = text.rfind("<--- HERE");
  if (here == std::string_view::npos) return {};
  const size_t marks = text.rfind('\n', here);
  if (marks == std::string_view::npos || marks == 0) return {};
  const size_t start = text.rfind('\n', marks - 1) + 1;
  const auto source = text.substr(start, marks - start),
             marked = text.substr(marks + 1, here - marks);
  const size_t column = marked.find('~');
  auto call = source.substr(std::min(column, source.size()));
  if (call.starts_with("return ")) call.remove_prefix(7);
  const size_t open = call.find('(');
  return open == std::string_view::npos ? std::string_view{} : stripped(call.substr(0, open));
}

// The word after `before`, up to white space or a quote.
std::string_view name_after(std::string_view text, std::string_view before) {
  const size_t at = text.find(before);
  if (at == std::string_view::npos) return {};
  auto word = text.substr(at + before.size());
  word = word.substr(0, std::min(word.find_first_of(" \n'\","), word.size()));
  while (!word.empty() && (word.back() == '.' || word.back() == ':')) word.remove_suffix(1);
  return word;
}

}  // namespace

std::string torch_reason(std::string_view text) {
  std::string out(stripped(reason_line(text)));
  const auto call = failed_call(text);
  if (!call.empty() && !contains(out, call)) out += " (in " + std::string(call) + ")";
  return out;
}

Error torch_load_error(const std::string& model, std::string_view text) {
  for (const auto before :
       {"Unknown builtin op: ", "Could not find schema for ", "Unknown type name '",
        "Couldn't find an operator for ", "No such operator "}) {
    const auto missing = name_after(text, before);
    if (missing.empty()) continue;
    return Error{
        .code = Code::MODEL_UNSUPPORTED,
        .what = "the model uses an operator or class that this libtorch lacks",
        .offered = model + ": " + std::string(missing),
        .needed = "operators of libtorch itself",
        .fix =
            "export the model without it: operators of torchvision and other packages are in "
            "Python libraries"};
  }
  if (contains(text, "maximum supported version"))
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the model was saved by a newer PyTorch than this libtorch",
                 .offered = model + ": " + torch_reason(text),
                 .fix = "save it with an older PyTorch, or export it to ONNX"};
  return Error{.code = Code::MODEL_INVALID,
               .what = "libtorch cannot load the model",
               .offered = model + ": " + torch_reason(text),
               .fix = "save the model again, then check it with weir inspect MODEL"};
}

Error torch_run_error(std::string_view text) {
  if (contains(text, "can't allocate memory"))
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = "libtorch has no memory for a frame",
                 .offered = torch_reason(text)};
  return Error{.code = Code::INVOKE_FAILED,
               .what = "libtorch failed on a frame",
               .offered = torch_reason(text)};
}

}  // namespace weir::engine
