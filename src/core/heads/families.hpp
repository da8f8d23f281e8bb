// The families of heads, and which of them fits a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/heads/head.hpp"

namespace weir::heads {

// In the order of the table of docs.
std::span<const Family* const> all_families();

// The family with this name or alias that has one of `tasks`. Throws Failure (OPTION_VALUE, with
// the names, and the nearest) if there is none.
const Family& family_named(std::string_view name, uint32_t tasks);

// The families with one of `tasks` that fit the model: those that are certain, else those that are
// possible. Throws Failure (SPEC_MISMATCH) for outputs that open_head() refuses by their size.
std::vector<const Family*> fitting(const ModelFacts& model, uint32_t tasks);

// The only family of fitting(). Throws Failure (SPEC_MISMATCH): none fits, with what families of
// these tasks need; several fit, with custom=head: for each.
const Family& recognise(const ModelFacts& model, uint32_t tasks);

// Opens a head of this family. Throws Failure (SPEC_MISMATCH) for outputs without a size or with
// more than 2^31 elements, and what the family's open() throws.
std::unique_ptr<Head> open_head(const Family& family, const ModelFacts& model,
                                const HeadOptions& options);

}  // namespace weir::heads
