// Parses in one pass and resolves names at the end, because a text may use them before.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/launch_graph.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

#include "core/text/text.hpp"
#include "launch/launch_tokens.hpp"

namespace weir::app {
namespace {

constexpr size_t kMaxTextBytes = size_t{1} << 20;

bool plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '%';
}

bool is_identifier(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), plain);
}

// "name.", "name.pad", ".pad"
bool is_reference(const LaunchToken& token) {
  const size_t dot = token.text.find('.');
  if (token.assigns || dot == std::string::npos) return false;
  const std::string_view text = token.text;
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
  LaunchPad pad = {};
  std::optional<size_t> caps_at = {};  // of caps between it and the end before it
};

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  Result<LaunchGraph> run() {
    auto tokens = launch_tokens(text_);
    if (!tokens) return tokens.error();
    if (auto status = read(*tokens); !status) return status.error();
    if (pending_) return no_element_after(pending_at_);
    if (graph_.elements.empty())
      return launch_error(text_, 0, "it is empty", "elements with ! between them");
    if (auto status = connect(); !status) return status.error();
    return std::move(graph_);
  }

 private:
  Status read(const std::vector<LaunchToken>& tokens) {
    for (auto token = tokens.begin(); token != tokens.end(); ++token) {
      if (pending_ && is_caps(token->text)) {
        // Caps extend to the next !: "video/x-raw, width=8 ! ...".
        caps_at_ = token->at;
        token = std::find_if(token, tokens.end(), [](const auto& t) { return t.text == "!"; });
        if (token == tokens.end()) return no_element_after(*caps_at_);
      } else if (auto status = take(*token); !status) {
        return status;
      }
    }
    return ok();
  }

  Status take(const LaunchToken& token) {
    if (token.text == "!") return link(token);
    if (token.text == "(" || token.text == ")" || token.text.ends_with(".(")) return ok();
    if (token.assigns) return property(token);
    if (is_reference(token)) {
      const size_t dot = token.text.find('.');
      join({std::nullopt,
            token.text.substr(0, dot),
            token.at,
            {token.text.substr(dot + 1), token.at + dot + 1}});
      return ok();
    }
    if (!is_identifier(token.text))
      return launch_error(text_, token.at, "this is not an element",
                          "an element, key=value, name.pad or !");
    return element(token);
  }

  Error no_element_after(size_t at) const {
    return launch_error(text_, at, "a link has no downstream element", "an element after !");
  }

  Status link(const LaunchToken& token) {
    if (pending_ || !last_)
      return launch_error(text_, token.at, "a link has no upstream element", "an element before !");
    pending_ = last_;
    pending_at_ = token.at;
    return ok();
  }

  Status property(const LaunchToken& token) {
    if (pending_ || !last_ || !last_->element)
      return launch_error(text_, token.at, "a property has no element before it",
                          "element key=value");
    const size_t equals = token.text.find('=');
    if (token.text.substr(0, equals) == "name")
      graph_.elements[*last_->element].name = token.text.substr(equals + 1);
    return ok();
  }

  Status element(const LaunchToken& token) {
    size_t& count = counts_[token.text];
    graph_.elements.push_back(
        {token.text, token.text + std::to_string(count), count, token.at, {}, {}});
    ++count;
    join({graph_.elements.size() - 1, "", token.at});
    return ok();
  }

  // Links `end` to the element before a pending !.
  void join(End end) {
    end.caps_at = std::exchange(caps_at_, std::nullopt);
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
      graph_.links.push_back(
          {*source, *sink, outputs.size(), to.at, to.caps_at.value_or(to.at), from.pad, to.pad});
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
  std::optional<size_t> caps_at_;  // of caps whose downstream end has not been read
  std::vector<std::pair<End, End>> ends_;
};

}  // namespace

Result<LaunchGraph> read_launch_graph(std::string_view text) {
  if (text.size() > kMaxTextBytes)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the text of the pipeline is too long",
                 .offered = std::to_string(text.size()) + " bytes",
                 .needed = "at most 1 MiB"};
  return Reader(text).run();
}

}  // namespace weir::app
