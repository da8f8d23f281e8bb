// Parses in one pass and resolves names at the end, because a text may use them before.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/launch_graph.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>

#include "core/text/text.hpp"
#include "launch/launch_tokens.hpp"

namespace weir::app {
namespace {

constexpr size_t kLongestText = size_t{1} << 20;

bool plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '%';
}

bool is_identifier(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), plain);
}

// "name.", "name.pad", ".pad"
bool is_reference(const LaunchToken& word) {
  const size_t dot = word.text.find('.');
  if (word.assigns || dot == std::string::npos) return false;
  const std::string_view text = word.text;
  const auto name = text.substr(0, dot), pad = text.substr(dot + 1);
  return (name.empty() || is_identifier(name)) && (pad.empty() || is_identifier(pad)) &&
         (!name.empty() || !pad.empty());
}

// Caps such as "video/x-raw,format=RGB": a / before any =.
bool is_caps(std::string_view text) {
  const size_t slash = text.find('/');
  return slash != std::string_view::npos && slash > 0 && slash < text.find('=') &&
         is_identifier(text.substr(0, slash));
}

// An end of a link: an element, or a name whose element may follow later.
struct End {
  std::optional<size_t> element;
  std::string name;
  size_t at = 0;
};

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  Result<LaunchGraph> run() {
    auto words = launch_tokens(text_);
    if (!words) return words.error();
    for (size_t i = 0; i < words->size(); ++i) {
      const LaunchToken& word = (*words)[i];
      if (pending_ && is_caps(word.text)) {
        // Caps extend to the next !: "video/x-raw, width=8 ! ...".
        while (i + 1 < words->size() && (*words)[i + 1].text != "!") ++i;
        if (++i == words->size()) return nothing_behind(word.at);
        continue;
      }
      if (auto status = take(word); !status) return status.error();
    }
    if (pending_) return nothing_behind(pending_at_);
    if (graph_.elements.empty())
      return launch_error(text_, 0, "it is empty", "elements with ! between them");
    if (auto status = connect(); !status) return status.error();
    return std::move(graph_);
  }

 private:
  Status take(const LaunchToken& word) {
    if (word.text == "!") return link(word);
    if (word.text == "(" || word.text == ")" || word.text.ends_with(".(")) return ok();
    if (word.assigns) return property(word);
    if (is_reference(word)) {
      join({std::nullopt, word.text.substr(0, word.text.find('.')), word.at});
      return ok();
    }
    if (!is_identifier(word.text))
      return launch_error(text_, word.at, "this is not an element",
                          "an element, key=value, name.pad or !");
    return element(word);
  }

  Error nothing_behind(size_t at) const {
    return launch_error(text_, at, "a link has no downstream element", "an element after !");
  }

  Status link(const LaunchToken& word) {
    if (pending_ || !last_)
      return launch_error(text_, word.at, "a link has no upstream element", "an element before !");
    pending_ = last_;
    pending_at_ = word.at;
    return ok();
  }

  Status property(const LaunchToken& word) {
    if (pending_ || !last_ || !last_->element)
      return launch_error(text_, word.at, "a property has no element before it",
                          "element key=value");
    const size_t equals = word.text.find('=');
    if (word.text.substr(0, equals) == "name")
      graph_.elements[*last_->element].name = word.text.substr(equals + 1);
    return ok();
  }

  Status element(const LaunchToken& word) {
    size_t& count = counts_[word.text];
    graph_.elements.push_back({word.text, word.text + std::to_string(count), count, {}, {}});
    ++count;
    join({graph_.elements.size() - 1, "", word.at});
    return ok();
  }

  // Links `end` to the element before a pending !.
  void join(End end) {
    if (pending_) ends_.emplace_back(*pending_, end);
    pending_.reset();
    last_ = std::move(end);
  }

  Result<size_t> find(const End& end) const {
    if (end.element) return *end.element;
    if (const auto found = named_.find(end.name); found != named_.end()) return found->second;
    std::vector<std::string> names;
    for (const auto& element : graph_.elements) names.push_back(element.name);
    const std::string close = nearest(end.name, names);
    Error error = launch_error(text_, end.at, "no element has the name " + end.name,
                               "an element with name=" + end.name);
    if (!close.empty()) error.fix = close + ". in place of " + end.name + ".";
    return error;
  }

  Status connect() {
    for (size_t i = 0; i < graph_.elements.size(); ++i)
      named_.emplace(graph_.elements[i].name, i);  // the first element with a name
    for (const auto& [from, to] : ends_) {
      const auto source = find(from), sink = find(to);
      if (!source) return source.error();
      if (!sink) return sink.error();
      auto& outputs = graph_.elements[*source].outputs;
      graph_.links.push_back({*source, *sink, outputs.size()});
      outputs.push_back(graph_.links.size() - 1);
      graph_.elements[*sink].inputs.push_back(graph_.links.size() - 1);
    }
    return ok();
  }

  const std::string_view text_;
  LaunchGraph graph_;
  std::map<std::string, size_t> counts_;  // elements per type
  std::map<std::string, size_t> named_;   // filled once all elements are known
  std::optional<End> last_, pending_;     // pending: the element before a ! without its right side
  size_t pending_at_ = 0;
  std::vector<std::pair<End, End>> ends_;
};

}  // namespace

Result<LaunchGraph> read_launch_graph(std::string_view text) {
  if (text.size() > kLongestText)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the text of the pipeline is too long",
                 .offered = std::to_string(text.size()) + " bytes",
                 .needed = "at most 1 MiB"};
  return Reader(text).run();
}

}  // namespace weir::app
