#include "server/app/recovery/snapshot_file.h"

#include "server/recording/recording_file.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/files/replace_file.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>

namespace zoned::app {

namespace {

namespace fs = std::filesystem;

/// Raise its last byte with every change of the ledger's fields.
constexpr std::array<char, 8> kRunMagic{'z', 'o', 'n', 'e', 'd', 'r', 'u', '1'};
constexpr std::string_view kSuffix = ".zsnap";

std::string path_of(const std::string& folder, Tick tick) {
    char name[40];
    std::snprintf(name, sizeof(name), "/%012lld", static_cast<long long>(tick));
    return folder + name + std::string(kSuffix);
}

std::uint64_t checksum_of(std::span<const std::uint8_t> bytes) {
    return recording::checksum_of({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

std::vector<SnapshotFile> snapshots_in(const std::string& folder) {
    std::vector<SnapshotFile> out;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == kSuffix) {
            out.push_back({std::atoll(entry.path().stem().c_str()), entry.path().string()});
        }
    }
    std::sort(out.begin(), out.end(), [](const SnapshotFile& a, const SnapshotFile& b) {
        return a.tick > b.tick;
    });
    return out;
}

std::string write_snapshot(const std::string& folder,
                           const World& world,
                           const RunLedger& ledger,
                           std::vector<std::uint8_t>& buffer) {
    std::vector<std::uint8_t> state;
    const std::string wrong = world.save(state);
    if (!wrong.empty()) {
        return wrong;
    }
    buffer.clear();
    core::FieldWriter archive(buffer);
    std::array<char, 8> magic = kRunMagic;
    std::uint64_t checksum = 0;
    archive(magic, checksum);
    const std::size_t body = buffer.size();
    archive(const_cast<RunLedger&>(ledger), state);  // writing leaves it as it is
    checksum = checksum_of(std::span(buffer).subspan(body));
    std::vector<std::uint8_t> head;
    core::FieldWriter again(head);
    again(magic, checksum);
    std::copy(head.begin(), head.end(), buffer.begin());
    const auto written =
        core::replace_file(path_of(folder, world.now()),
                           {reinterpret_cast<const char*>(buffer.data()), buffer.size()},
                           0640);
    return written ? "" : written.error();
}

core::Result<std::vector<std::uint8_t>> read_snapshot(const SnapshotFile& file) {
    using Bytes = std::vector<std::uint8_t>;
    std::ifstream in(file.path, std::ios::binary);
    Bytes bytes{std::istreambuf_iterator<char>(in), {}};
    core::FieldReader archive(bytes);
    std::array<char, 8> magic{};
    std::uint64_t checksum = 0;
    archive(magic, checksum);
    if (!in.good() && !in.eof()) {
        return core::Result<Bytes>::failure("cannot read '" + file.path + "'");
    }
    if (!archive.good() || magic != kRunMagic) {
        return core::Result<Bytes>::failure("'" + file.path + "' is no snapshot of this program");
    }
    if (checksum != checksum_of(std::span(bytes).last(archive.left()))) {
        return core::Result<Bytes>::failure("'" + file.path + "' is damaged: its checksum differs");
    }
    return bytes;
}

std::string load_snapshot(const std::vector<std::uint8_t>& bytes, World& world, RunLedger& ledger) {
    core::FieldReader archive(bytes);
    std::array<char, 8> magic{};
    std::uint64_t checksum = 0;
    std::vector<std::uint8_t> state;
    archive(magic, checksum, ledger, state);
    return archive.good() ? world.load(state) : archive.wrong();
}

void remove_snapshots_before(const std::string& folder, Tick tick) {
    std::error_code error;
    for (const SnapshotFile& file : snapshots_in(folder)) {
        if (file.tick < tick) {
            fs::remove(file.path, error);
        }
    }
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".part" &&
            std::atoll(entry.path().stem().stem().c_str()) < tick) {
            fs::remove(entry.path(), error);
        }
    }
}

}  // namespace zoned::app
