// Keeps the models by id.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_query_serversrc/served_pairs.hpp"

#include <map>
#include <mutex>

namespace weir {
namespace {

struct Pairs {
  std::mutex mutex;  // guards models
  std::map<uint32_t, std::shared_ptr<net::ServedModel>> models;
};

Pairs& pairs() {
  static auto& all = *new Pairs;  // threads may outlive static objects
  return all;
}

}  // namespace

Status add_pair(uint32_t id, const std::shared_ptr<net::ServedModel>& model) {
  std::lock_guard lock(pairs().mutex);
  if (pairs().models.emplace(id, model).second) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "another tensor_query_serversrc of this process has the same id",
      .offered = "id=" + std::to_string(id),
      .needed = "an id for each pair of tensor_query_serversrc and tensor_query_serversink",
      .fix = "id=" + std::to_string(id + 1) + " for both elements of a pair"};
}

void remove_pair(uint32_t id, const net::ServedModel& model) {
  std::lock_guard lock(pairs().mutex);
  const auto found = pairs().models.find(id);
  if (found != pairs().models.end() && found->second.get() == &model) pairs().models.erase(found);
}

std::shared_ptr<net::ServedModel> model_of_pair(uint32_t id) {
  std::lock_guard lock(pairs().mutex);
  const auto found = pairs().models.find(id);
  return found == pairs().models.end() ? nullptr : found->second;
}

}  // namespace weir
