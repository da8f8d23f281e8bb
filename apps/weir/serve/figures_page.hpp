// The figures of elements in the text format of Prometheus.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "report.hpp"

namespace weir::app {

// `ledgers`: as of ledgers(); elements are named MODEL-source, MODEL-filter and MODEL-sink. Each
// number of their stats is a metric with the labels model and element:
// weir_received_total{model="resnet", element="tensor_filter"} 3. Durations are in seconds.
std::string figures_page(const Json& ledgers);

}  // namespace weir::app
