// Resolves addresses over time, and the links between elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/graph.hpp"

#include <algorithm>
#include <set>

namespace weir::trace {

template <class T>
size_t Graph::find(const Places& places, const std::vector<T>& all, const void* object,
                   int64_t time) {
  const auto found = places.find(object);
  if (found == places.end()) return kNone;
  for (auto id = found->second.rbegin(); id != found->second.rend(); ++id)
    if (all[*id].from <= time && time <= all[*id].until) return *id;
  return kNone;
}

size_t Graph::element_at(const void* object, int64_t time) const {
  return find(element_places_, elements_, object, time);
}

size_t Graph::pad_at(const void* object, int64_t time) const {
  return find(pad_places_, pads_, object, time);
}

size_t Graph::see_element(const void* object, int64_t time) {
  auto& ids = element_places_[object];
  if (!ids.empty() && elements_[ids.back()].until == kForEver) return ids.back();
  ids.push_back(elements_.size());
  elements_.emplace_back().from = time;
  return ids.back();
}

void Graph::name_element(const void* object, const void* parent, std::string name,
                         std::string factory, bool is_bin, int64_t time) {
  const size_t parent_id = parent ? see_element(parent, time) : kNone;
  Element& element = elements_[see_element(object, time)];
  if (parent) element.parent = parent_id;
  element.name = std::move(name);
  element.factory = std::move(factory);
  element.is_bin = is_bin;
}

size_t Graph::see_pad(const void* object, const void* element, const std::string& name,
                      bool is_source, int64_t time) {
  auto& ids = pad_places_[object];
  if (ids.empty() || pads_[ids.back()].until != kForEver) {
    ids.push_back(pads_.size());
    pads_.emplace_back().from = time;
  }
  const size_t id = ids.back();
  pads_[id].name = name;
  pads_[id].is_source = is_source;
  if (element) pads_[id].element = see_element(element, time);
  return id;
}

void Graph::join_halves(const void* ghost, const void* inner) {
  const size_t a = pad_at(ghost, kForEver), b = pad_at(inner, kForEver);
  if (a == kNone || b == kNone) return;
  pads_[a].half = b;
  pads_[b].half = a;
}

void Graph::link(const void* source, const void* sink, int64_t time) {
  const size_t a = pad_at(source, kForEver), b = pad_at(sink, kForEver);
  if (a == kNone || b == kNone) return;
  pads_[a].peers.emplace_back(time, b);
  pads_[b].peers.emplace_back(time, a);
}

void Graph::unlink(const void* source, const void* sink, int64_t time) {
  for (const void* object : {source, sink})
    if (const size_t id = pad_at(object, kForEver); id != kNone)
      pads_[id].peers.emplace_back(time, kNone);
}

bool Graph::destroyed(const void* object, int64_t time) {
  const size_t element = element_at(object, kForEver), pad = pad_at(object, kForEver);
  if (element != kNone) elements_[element].until = time;
  if (pad != kNone) pads_[pad].until = time;
  return element != kNone || pad != kNone;
}

size_t Graph::peer_at(size_t pad, int64_t time) const {
  if (pad == kNone) return kNone;
  const auto& peers = pads_[pad].peers;
  const auto after = std::upper_bound(peers.begin(), peers.end(), time,
                                      [](int64_t t, const auto& peer) { return t < peer.first; });
  return after == peers.begin() ? kNone : std::prev(after)->second;
}

size_t Graph::owner(size_t pad) const {
  if (pad == kNone) return kNone;
  const Pad& it = pads_[pad];
  if (it.element != kNone || it.half == kNone) return it.element;
  return pads_[it.half].element;
}

bool Graph::has_pads(size_t element, bool source) const {
  return std::any_of(pads_.begin(), pads_.end(), [&](const Pad& pad) {
    return pad.element == element && pad.is_source == source;
  });
}

// Follows data from a pad to the pad it reaches: itself, or beyond the ghost pad that it is half
// of.
size_t Graph::follow(size_t pad) const {
  for (size_t steps = 0; pad != kNone && steps < pads_.size(); ++steps) {
    if (pads_[pad].half == kNone) return pad;
    const auto& peers = pads_[pads_[pad].half].peers;
    const auto last = std::find_if(peers.rbegin(), peers.rend(),
                                   [](const auto& peer) { return peer.second != kNone; });
    pad = last == peers.rend() ? kNone : last->second;
  }
  return kNone;
}

std::vector<std::pair<size_t, size_t>> Graph::edges() const {
  std::set<std::pair<size_t, size_t>> out;
  for (size_t id = 0; id < pads_.size(); ++id) {
    const Pad& pad = pads_[id];
    if (!pad.is_source || pad.element == kNone || pad.half != kNone) continue;
    for (const auto& peer : pad.peers)
      if (const size_t end = follow(peer.second); end != kNone && pads_[end].element != kNone)
        out.emplace(id, end);
  }
  return {out.begin(), out.end()};
}

}  // namespace weir::trace
