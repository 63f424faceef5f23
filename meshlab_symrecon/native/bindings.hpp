// The parts of the Python module, one function a part.
#pragma once

#include <nanobind/nanobind.h>

namespace symrecon {

void bind_clustering(nanobind::module_& module);
void bind_deviation(nanobind::module_& module);
void bind_crust(nanobind::module_& module);
void bind_noise(nanobind::module_& module);
void bind_interrupts(nanobind::module_& module);
void bind_labels(nanobind::module_& module);
void bind_memory(nanobind::module_& module);
void bind_symmetry(nanobind::module_& module);
void bind_streams(nanobind::module_& module);
void bind_surfaces(nanobind::module_& module);

}  // namespace symrecon
