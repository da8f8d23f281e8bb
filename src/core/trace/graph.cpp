// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/graph.hpp"

#include <algorithm>
#include <map>

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

void Graph::set_waits(const void* element, Waits waits) {
  if (const size_t id = element_at(element, kForEver); id != kNone) elements_[id].waits = waits;
}

void Graph::removed(const void* element) {
  if (const size_t id = element_at(element, kForEver); id != kNone) elements_[id].is_removed = true;
}

void Graph::added(const void* element) {
  if (const size_t id = element_at(element, kForEver); id != kNone)
    elements_[id].is_removed = false;
}

void Graph::set_caps(const void* pad, std::string caps) {
  const size_t id = pad_at(pad, kForEver);
  if (id == kNone || pads_[id].caps == caps) return;
  if (!pads_[id].caps.empty()) ++pads_[id].caps_changes;
  pads_[id].caps = std::move(caps);
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

size_t Graph::end_at(size_t source_pad, int64_t time) const {
  size_t pad = source_pad;
  for (size_t steps = 0; pad != kNone && steps < pads_.size(); ++steps) {
    const size_t peer = peer_at(pad, time);
    if (peer == kNone || pads_[peer].half == kNone) return peer;
    pad = pads_[peer].half;  // of a ghost pad: data continues at its other half
  }
  return kNone;
}

// Adds the edges from `source` that `pad`, on the way, was part of between two times.
void Graph::add_edges(size_t source, size_t pad, int64_t from, int64_t until, size_t steps,
                      std::map<std::pair<size_t, size_t>, bool>* lasting) const {
  if (steps == pads_.size()) return;  // ghost pads in a circle
  const auto& peers = pads_[pad].peers;
  for (size_t i = 0; i < peers.size(); ++i) {
    const auto [linked, peer] = peers[i];
    if (peer == kNone) continue;
    const int64_t begin = std::max(from, linked);
    const int64_t end = std::min({until, i + 1 < peers.size() ? peers[i + 1].first : kForEver,
                                  pads_[pad].until, pads_[peer].until});
    if (begin >= end) continue;
    if (const size_t half = pads_[peer].half; half != kNone)
      add_edges(source, half, begin, end, steps + 1, lasting);
    else if (pads_[peer].element != kNone)
      (*lasting)[{source, peer}] |= end == kForEver;
  }
}

std::vector<Edge> Graph::edges() const {
  std::map<std::pair<size_t, size_t>, bool> lasting;
  for (size_t id = 0; id < pads_.size(); ++id) {
    const Pad& pad = pads_[id];
    if (pad.is_source && pad.element != kNone && pad.half == kNone)
      add_edges(id, id, 0, kForEver, 0, &lasting);
  }
  std::vector<Edge> out;
  out.reserve(lasting.size());
  for (const auto& [pads, lasts] : lasting) out.push_back({pads.first, pads.second, lasts});
  return out;
}

}  // namespace weir::trace
