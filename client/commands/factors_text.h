// A table of form factors as the files and the summary that `isolux factors` gives.
#pragma once

#include <string>

#include "worker/factors/factors.h"

namespace isolux {

// Lines p,q,F_pq,C_pq_m2,error for every factor other than 0, both ways, sorted; error is that of
// F_pq. Where both sides of polygons take part, columns side_p,side_q follow.
std::string FactorsAsCsv(const FactorTable& table);

// Lines polygon,area_m2,row_sum,missing,row_sum_before,row_error; `missing` is 1 - row_sum.
std::string RowsAsCsv(const FactorTable& table);

// One object: polygons, rows, factors and the figures of the summary. `polygons`: in the file.
std::string FactorsAsJson(const FactorTable& table, uint32_t polygons, double tolerance,
                          double seconds);

// How it went, for people.
std::string FactorsSummary(const FactorTable& table, double tolerance, double seconds);

}  // namespace isolux
