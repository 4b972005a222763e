#include "tests/bench/public_data.h"

#include <bit>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

namespace zoned::bench {

namespace {

static_assert(std::endian::native == std::endian::little, "the data is little-endian");
static_assert(sizeof(CubeRecord) == 8 * sizeof(std::int32_t));

struct CloseUnpacked {
    void operator()(std::FILE* pipe) const { pclose(pipe); }
};

using Unpacked = std::unique_ptr<std::FILE, CloseUnpacked>;

/// The decompressed text of a file of cubes901, by xz; null, with the reason, where there is none.
Unpacked unpack(const std::string& name, std::string& why) {
    const std::string file = data_directory() + "/cubes901/" + name + ".xz";
    if (!std::filesystem::exists(file)) {
        why = file + " is not there: no rows of it";
        return nullptr;
    }
    return Unpacked(popen(("xz -dc '" + file + "' 2>/dev/null").c_str(), "r"));
}

}  // namespace

std::string data_directory() {
    const char* named = std::getenv("ZONED_DATA");
    return named != nullptr ? named : ZONED_SOURCE_DIR "/../shared/data";
}

std::vector<CubeRecord> read_cubes(const std::string& which, std::size_t frames, std::string& why) {
    const std::string name = "cubes901_" + which + ".bin";
    const Unpacked pipe = unpack(name, why);
    if (!pipe) {
        return {};
    }
    std::vector<CubeRecord> records(frames * kCubes);
    const std::size_t read =
        std::fread(records.data(), sizeof(CubeRecord), records.size(), pipe.get());
    records.resize(read / kCubes * kCubes);
    if (records.empty()) {
        why = "xz could not read " + name + ": no rows of it";
    }
    return records;
}

}  // namespace zoned::bench
