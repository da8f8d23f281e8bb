// Writes the tables and pictures of a run in the order of questions: what, where, how fast, why.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/report_page.hpp"

#include <algorithm>

#include "core/config/install_paths.hpp"
#include "core/trace/layout.hpp"
#include "run/charts.hpp"
#include "run/graph_picture.hpp"
#include "run/html.hpp"
#include "run/ledger_table.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string count(const Json& value) {
  return fixed(value, 0);
}

std::string name_of(const Json& summary, const Json& element) {
  return element.is_number() ? summary["elements"][element.get<size_t>()]["name"].get<std::string>()
                             : std::string();
}

// The elements in the pipeline except bins, in stream order.
std::vector<size_t> shown_elements(const Json& summary) {
  std::vector<size_t> out;
  for (size_t i = 0; i < summary["elements"].size(); ++i) {
    const Json& element = summary["elements"][i];
    if (!element["bin"] && !element["parent"].is_null()) out.push_back(i);
  }
  std::vector<std::pair<size_t, size_t>> arrows;
  for (const Json& link : summary["links"])
    if (link["from"].is_number() && link["to"].is_number())
      arrows.emplace_back(link["from"], link["to"]);
  const auto places = trace::lay_out(summary["elements"].size(), arrows).boxes;
  std::stable_sort(out.begin(), out.end(), [&places](size_t a, size_t b) {
    return std::pair(places[a].column, places[a].row) < std::pair(places[b].column, places[b].row);
  });
  return out;
}

const Json* ledger_of(const Json& outcome, const Json& element) {
  for (const Json& ledger : outcome["ledger"])
    if (ledger["name"] == element["name"] && ledger["element"] == element["factory"])
      return &ledger["stats"];
  return nullptr;
}

std::string drops(const Json& stats) {
  constexpr std::string_view kPrefix = "dropped-";
  std::vector<std::string> out;
  for (const auto& [name, value] : stats.items())
    if (name.starts_with(kPrefix) && value.is_number() && value != 0)
      out.push_back(name.substr(kPrefix.size()) + " " + count(value));
  return join(out, ", ");
}

std::string complaints(const Json& list, const char* kind) {
  std::string out;
  for (const Json& item : list) {
    out += "<li><b class=\"bad\">" + std::string(kind) + "</b> ";
    if (item.value("element", "") != "") out += escaped(item.value("element", "")) + ": ";
    out += escaped(item.value("id", "")) + " " + escaped(item.value("what", ""));
    for (const char* part : {"offered", "needed", "difference", "fix", "debug"})
      if (item.value(part, "") != "" &&
          (part != std::string("debug") || item.value("id", "") == ""))
        out += "<br>" + std::string(part) + ": " + escaped(item.value(part, ""));
    out += "</li>\n";
  }
  return out;
}

std::string head(const Json& outcome, const Json& summary, const std::string& pipeline) {
  const std::string result = outcome["result"];
  std::string out = "<h1>Pipeline report</h1>\n<pre id=\"pipeline\">" + escaped(pipeline) +
                    "</pre>\n<p id=\"result\">";
  const std::string unit = outcome["frames"] != 0 ? "frames" : "buffers";
  out += result == "eos"          ? "Ended"
         : result == "error"      ? "<b class=\"bad\">Failed</b>"
         : result == "time-limit" ? "Stopped by --timeout"
                                  : "Interrupted";
  out += " after " + fixed(outcome["seconds"], 3) + " s: " + count(outcome[unit]) + " " + unit +
         ", " + fixed(outcome["frame_rate"], 1) + " " + unit + "/s";
  if (summary["lost"] != 0)
    out += ". <b class=\"bad\">The logs were full: " + count(summary["lost"]) +
           " records are missing, so figures below are too small.</b>";
  out += "</p>\n";
  const std::string entries =
      complaints(outcome["errors"], "error") + complaints(outcome["warnings"], "warning");
  return entries.empty() ? out : out + "<ul class=\"complaints\">" + entries + "</ul>\n";
}

// `stats` is the element's ledger, null if it has none.
std::vector<std::string> element_row(const Json& element, const Json* stats, double run_seconds) {
  const double in = element["in"]["frames"], work = element["work"];
  const auto stat = [stats](const char* name) {
    return stats && stats->contains(name) ? count((*stats)[name]) : std::string();
  };
  return {escaped(element["name"].get<std::string>()),
          escaped(element["factory"].get<std::string>()),
          count(element["in"]["frames"]),
          count(element["out"]["frames"]),
          count(element["refused"]),
          rate_text(in > 0 ? element["in"]["rate"] : element["out"]["rate"]),
          in > 0 ? duration_text(work) : "",
          in > 0 ? duration_text(work / in) : "",
          in > 0 ? duration_text(element["longest"]) : "",
          in > 0 && run_seconds > 0 ? fixed(work / run_seconds * 100, 1) + " %" : "",
          element["thread_work"] > 0 ? duration_text(element["thread_work"]) : "",
          duration_text(element["states"].get<double>() + element["events"].get<double>()),
          stat("bytes-copied"),
          stat("dropped"),
          stats ? drops(*stats) : ""};
}

std::string elements(const Json& outcome, const Json& summary, const std::vector<size_t>& shown) {
  Rows rows{{"element", "is a", "frames in", "out", "refused", "frames/s", "time", "a frame",
             "longest", "of the run", "own thread", "start, events", "bytes copied", "dropped",
             "why"}};
  for (const size_t i : shown) {
    const Json& element = summary["elements"][i];
    rows.push_back(element_row(element, ledger_of(outcome, element), summary["seconds"]));
  }
  return "<h2>Elements</h2>\n" + html_table(rows, "elements", {1, 14}) +
         "<p class=\"note\">The time of an element excludes the time of its downstream elements. "
         "Waiting counts: a sink waits for the clock, a full queue waits for space. Own thread is "
         "the "
         "time between the pushes of a streaming thread that starts at the element: a source "
         "produces "
         "a frame in it, a queue waits for one. Copied and dropped come from the ledger of Weir's "
         "elements.</p>\n";
}

// The inference servers of filters; "" if there are none.
std::string servers(const Json& outcome) {
  Rows rows = server_rows(outcome["ledger"]);
  if (rows.empty()) return "";
  for (auto& row : rows)
    for (auto& cell : row) cell = escaped(cell);
  return "<h2>Servers</h2>\n" + html_table(rows, "servers", {0, 1, 7});
}

std::string links(const Json& summary) {
  Rows rows{{"from", "to", "frames", "frames/s", "bytes", "bytes/s"}};
  const auto end = [&](const Json& link, const char* element, const char* pad) {
    return escaped(name_of(summary, link[element]) + "." + link[pad].get<std::string>());
  };
  for (const Json& link : summary["links"]) {
    const double frames = link["frames"], rate = link["rate"], bytes = link["bytes"];
    rows.push_back({end(link, "from", "from_pad"), end(link, "to", "to_pad"), count(link["frames"]),
                    rate_text(rate), bytes_text(bytes),
                    rate > 0 ? bytes_text(bytes / frames * rate) : ""});
  }
  return "<h2>Links</h2>\n" + html_table(rows, "links", {1});
}

std::string queues(const Json& summary) {
  if (summary["queues"].empty()) return "";
  Rows rows{{"queue", "most frames", "mean", "fullest", "not passed on"}};
  std::string charts;
  for (const Json& queue : summary["queues"]) {
    const std::string name = escaped(name_of(summary, queue["element"]));
    rows.push_back({name, count(queue["most"]), fixed(queue["mean"], 2),
                    fixed(queue["fullest"].get<double>() * 100, 0) + " %",
                    count(queue["not_passed_on"])});
    charts += "<h3>" + name + "</h3>\n" + level_chart(queue, summary["seconds"]);
  }
  return "<h2>Queues</h2>\n" + html_table(rows, "queues") +
         "<p class=\"note\">Fullest is the highest level relative to the limit in frames, bytes or "
         "time. "
         "Not passed on: leaked, flushed, or still in the queue at the end. The charts show the "
         "frames "
         "in the queue over time.</p>\n" +
         charts;
}

std::string latencies(const Json& summary) {
  Rows rows{
      {"from", "to", "frames", "least", "median", "mean", "95 %", "99 %", "most", "not matched"}};
  std::string charts;
  for (const Json& item : summary["latencies"]) {
    std::string from = name_of(summary, item["source"]);
    if (item["origin"] != item["source"])
      from = name_of(summary, item["origin"]) + "." + item["origin_pad"].get<std::string>() +
             " (of " + from + ")";
    from = escaped(from);
    const std::string to = escaped(name_of(summary, item["sink"]));
    std::vector<std::string> row{from, to, count(item["frames"])};
    for (const char* name : {"least", "median", "mean", "percentile_95", "percentile_99", "most"})
      row.push_back(item["frames"] > 0 ? duration_text(item[name]) : "");
    row.push_back(count(item["unmatched"]));
    rows.push_back(std::move(row));
    if (item["frames"] > 0)
      charts.append("<h3>").append(from).append(" to ").append(to).append("</h3>\n").append(
          histogram(item));
  }
  if (rows.size() == 1) return "";
  return "<h2>Latency</h2>\n" + html_table(rows, "latencies", {1}) +
         "<p class=\"note\">From the push to the arrival of a frame with the same time-stamp at "
         "the sink. A "
         "file has no time-stamps before its demuxer or parser: latency counts from there. The "
         "charts show the number of frames for each latency, with steps that grow "
         "with the latency.</p>\n" +
         charts;
}

}  // namespace

std::string report_page(const Json& outcome, const Json& summary, const std::string& pipeline) {
  std::string out = page_begin("Pipeline report") + head(outcome, summary, pipeline);
  const auto shown = shown_elements(summary);
  out +=
      "<h2>Graph</h2>\n" + graph_picture(summary, shown) +
      "<p class=\"note\">The deeper the colour, the larger the element's own time among all.</p>\n";
  out += elements(outcome, summary, shown) + servers(outcome) + links(summary) + queues(summary) +
         latencies(summary);
  return out + "<p class=\"note\">Written by weir " + config::kVersion + " run --report; " +
         count(summary["records"]) + " records in " + fixed(summary["seconds"], 3) +
         " s.</p>\n</body></html>\n";
}

}  // namespace weir::app
