// ProgramCache: built kernels in a folder, so that the next start need not build them again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace zoned::compute {

/// Everything that a built program depends on. All of it is written into the file and compared in
/// full.
struct ProgramKey {
    std::string device;   ///< name and platform
    std::string driver;   ///< version
    std::string options;  ///< of the compiler
    std::string source;   ///< expanded
};

/// One file per key. A file is taken only where its key is the same and its checksum right. A file
/// that is damaged, cut short or of another program counts as missing, and is written anew. The
/// checksum finds damage, not forgery: the folder must belong to the user that runs the server.
class ProgramCache {
  public:
    ProgramCache() = default;

    /// Empty: nothing is kept.
    explicit ProgramCache(std::string folder) : folder_(std::move(folder)) {}

    /// The binary of a key, or nothing.
    [[nodiscard]] std::optional<std::vector<std::uint8_t>> load(const ProgramKey& key) const;

    /// Writes the file anew, by renaming, so that readers see all of it or none. False where that
    /// is not possible; the cache is then merely of no use.
    bool store(const ProgramKey& key, std::span<const std::uint8_t> binary) const;

    /// Where the program of a key lies; empty without a folder.
    [[nodiscard]] std::string path_of(const ProgramKey& key) const;

  private:
    std::string folder_;
};

}  // namespace zoned::compute
