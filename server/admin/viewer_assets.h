// Viewer assets: the files of the page in server/admin/viewer, as parts of the program.
#pragma once

#include <span>
#include <string_view>

namespace zoned::admin {

struct ViewerAsset {
    std::string_view path;  ///< of the request
    std::string_view type;
    std::string_view content;
};

/// The page, its style and its script, which esbuild has put together.
[[nodiscard]] std::span<const ViewerAsset> viewer_assets();

}  // namespace zoned::admin
