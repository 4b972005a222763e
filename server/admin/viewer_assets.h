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

/// The page, its style and its script, which esbuild has put together; and those of the page to
/// play on, /play, with /play_missing in its place where the program was built without the module.
[[nodiscard]] std::span<const ViewerAsset> viewer_assets();

/// The client as a WebAssembly module; empty where the program was built without one.
[[nodiscard]] std::string_view web_client_module();

}  // namespace zoned::admin
