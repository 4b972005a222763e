#include "server/app/recovery/snapshot_file.h"

#include "server/recording/recording_file.h"
#include "shared/core/archive/field_archive.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
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

/// The system's text for a failed call; empty: all is written and on disk.
std::string put(int fd, std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return std::strerror(errno);
        }
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return ::fsync(fd) == 0 ? "" : std::strerror(errno);
}

std::string put_file(const std::string& path, std::span<const std::uint8_t> bytes) {
    const std::string part = path + ".part";
    const int fd = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    if (fd < 0) {
        return "cannot create '" + part + "': " + std::strerror(errno);
    }
    std::string wrong = put(fd, bytes);
    ::close(fd);
    if (wrong.empty() && ::rename(part.c_str(), path.c_str()) != 0) {
        wrong = std::strerror(errno);
    }
    if (!wrong.empty()) {
        ::unlink(part.c_str());
        return "cannot write '" + path + "': " + wrong;
    }
    recording::sync_folder(fs::path(path).parent_path().string());
    return {};
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
    return put_file(path_of(folder, world.now()), buffer);
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
