// Kernel source: the OpenCL C files embedded in the program, with their includes put in.
#pragma once

#include "shared/core/result.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace zoned::compute {

struct KernelFile {
    std::string_view path;  ///< from the root of the repository: "kernels/particles.cl"
    std::string_view text;
};

/// All files of kernels/, written by CMake from kernels/*.cl and kernels/include/*.h.
std::span<const KernelFile> kernel_files();

/// Finds the text of a path; nothing where there is no such file.
using FindKernelFile = std::function<std::optional<std::string_view>(std::string_view path)>;

/// The text of `path` with each "kernels/include/..." put in once, in the place of its first
/// include. #line directives make the compiler name file and line as they are in the repository.
/// Fails with file and line of an include that is not there.
core::Result<std::string> expand_kernel(std::string_view path, const FindKernelFile& find);

/// A compiler's log about such a text. Compilers that ignore #line (NVIDIA's) say "<kernel>:LINE"
/// of the whole text; that becomes the file and its line.
std::string name_places(std::string_view log, std::string_view source);

/// expand_kernel from kernel_files().
core::Result<std::string> kernel_source(std::string_view path);

}  // namespace zoned::compute
