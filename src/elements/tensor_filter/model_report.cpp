// Opens a model only to read its description.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_report.hpp"

#include "elements/tensor_filter/open_model.hpp"

namespace weir {
namespace {

// Compares the settings that decide which tensors a model has.
bool same_model(const FilterSettings& a, const FilterSettings& b) {
  return a.framework == b.framework && a.model == b.model && a.custom == b.custom &&
         a.accelerator == b.accelerator && static_cast<const DeclaredTensors&>(a) == b;
}

}  // namespace

void ModelReport::negotiated(Tensors tensors) {
  std::lock_guard lock(mutex_);
  stream_ = std::make_shared<const Tensors>(std::move(tensors));
}

void ModelReport::forget() {
  std::lock_guard lock(mutex_);
  stream_.reset();
}

std::shared_ptr<const ModelReport::Tensors> ModelReport::of_stream() const {
  std::lock_guard lock(mutex_);
  return stream_;
}

std::shared_ptr<const ModelReport::Tensors> ModelReport::of_settings(
    const FilterSettings& settings) {
  // Reading a property does not start a worker process.
  if (settings.model.empty() || settings.isolate != IsolateChoice::None) return nullptr;
  FilterSettings alone = settings;
  alone.workers = 1;
  alone.batch_size = 1;
  alone.invoke_async = false;
  std::lock_guard lock(opening_);
  if (known_ && same_model(alone, known_of_)) return known_;
  std::vector<Error> warnings;
  const auto opened = OpenModel::open(alone, nullptr, &warnings);
  if (!opened) return nullptr;
  known_ = std::make_shared<const Tensors>(Tensors{(*opened)->inputs(), (*opened)->outputs()});
  known_of_ = std::move(alone);
  return known_;
}

}  // namespace weir
