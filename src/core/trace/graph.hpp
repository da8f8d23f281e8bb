// Graph: the elements, pads and links that a tracer saw, with their lifetimes, to resolve the
// addresses in records to names. Addresses are compared, never dereferenced.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace weir::trace {

inline constexpr size_t kNone = std::numeric_limits<size_t>::max();
inline constexpr int64_t kForEver = std::numeric_limits<int64_t>::max();

// What an element waits for, so that its time is not all work. With its first frame any element may
// wait.
enum class Waits : uint8_t {
  Never,
  Room,    // queues: for room when frames come, for frames to push
  Clock,   // elements that synchronise to the clock
  Start,   // other sinks: with their first frame, until the pipeline plays
  Device,  // live sources: for the next frame
  Inputs   // elements of several inputs: for the others
};

struct Element {
  int64_t from = 0, until = kForEver;  // lifetime
  std::string name, factory;           // "" until it is named
  size_t parent = kNone;               // the bin that contains it
  bool is_bin = false;
  bool is_removed = false;  // it was taken out of its bin before the end
  Waits waits = Waits::Never;
};

struct Pad {
  int64_t from = 0, until = kForEver;
  std::string name;
  bool is_source = false;
  size_t element = kNone;  // kNone for the inner half of a ghost pad
  size_t half = kNone;     // of a ghost pad: its inner half, and the other way round
  std::string caps;        // the last that it sent, "" before
  unsigned caps_changes = 0;
  std::vector<std::pair<int64_t, size_t>> peers;  // the linked pad (or kNone) from that time on
};

struct Edge {
  size_t source = kNone, sink = kNone;  // pads
  bool lasts = false;                   // it still existed at the end
  bool operator==(const Edge&) const = default;
};

// Not thread-safe. Elements and pads are numbered in the order in which they were seen.
class Graph {
 public:
  size_t see_element(const void* object, int64_t time);
  void name_element(const void* object, const void* parent, std::string name, std::string factory,
                    bool is_bin, int64_t time);
  // `element` may be null and become known later.
  size_t see_pad(const void* object, const void* element, const std::string& name, bool is_source,
                 int64_t time);
  void join_halves(const void* ghost, const void* inner);  // both were seen before
  void link(const void* source, const void* sink, int64_t time);
  void unlink(const void* source, const void* sink, int64_t time);
  // The next four ignore objects that were not seen.
  void set_waits(const void* element, Waits waits);
  void removed(const void* element);  // from its bin
  void added(const void* element);
  void set_caps(const void* pad, std::string caps);
  bool destroyed(const void* object, int64_t time);  // returns whether it was one of these

  const std::vector<Element>& elements() const noexcept { return elements_; }
  const std::vector<Pad>& pads() const noexcept { return pads_; }

  // The object with that address at that time; kNone if there was none.
  size_t element_at(const void* object, int64_t time) const;
  size_t pad_at(const void* object, int64_t time) const;
  size_t peer_at(size_t pad, int64_t time) const;
  // The element a pad belongs to; for the inner half of a ghost pad, its bin.
  size_t owner(size_t pad) const;
  bool has_pads(size_t element, bool source) const;
  // The sink pad that data from a source pad reached at that time, through ghost pads; kNone if it
  // reached none.
  size_t end_at(size_t source_pad, int64_t time) const;
  // Links between elements other than bins, through ghost pads, each once.
  std::vector<Edge> edges() const;

 private:
  using Places = std::map<const void*, std::vector<size_t>>;
  template <class T>
  static size_t find(const Places& places, const std::vector<T>& all, const void* object,
                     int64_t time);
  void add_edges(size_t source, size_t pad, int64_t from, int64_t until, size_t steps,
                 std::map<std::pair<size_t, size_t>, bool>* lasting) const;

  std::vector<Element> elements_;
  std::vector<Pad> pads_;
  Places element_places_, pad_places_;
};

}  // namespace weir::trace
