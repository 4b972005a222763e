#include "server/compute/program_cache.h"

#include "shared/core/state_hash.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace zoned::compute {

namespace {

constexpr std::string_view kMagic = "zoned program 1\n";
constexpr std::uint64_t kMostBytes = 64U << 20U;

using Bytes = std::vector<std::uint8_t>;

std::uint64_t hash_of(std::span<const std::uint8_t> bytes, std::uint64_t salt) {
    core::StateHash hash;
    hash.add(salt);
    hash.add_bytes(bytes);
    return hash.value();
}

void put(Bytes& out, std::uint64_t number) {
    for (unsigned i = 0; i < 8; ++i) {
        out.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
    }
}

std::uint64_t number_at(std::span<const std::uint8_t> bytes) {
    std::uint64_t number = 0;
    for (unsigned i = 0; i < 8; ++i) {
        number |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
    }
    return number;
}

/// The head of the file, before the binary: all of the key.
Bytes head_of(const ProgramKey& key) {
    Bytes head(kMagic.begin(), kMagic.end());
    for (const std::string* part : {&key.device, &key.driver, &key.options, &key.source}) {
        put(head, part->size());
        head.insert(head.end(), part->begin(), part->end());
    }
    return head;
}

Bytes read_all(const std::string& path) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error || size > kMostBytes) {
        return {};
    }
    std::ifstream in(path, std::ios::binary);
    Bytes bytes(size);
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (!in) {
        return {};
    }
    return bytes;
}

}  // namespace

std::string ProgramCache::path_of(const ProgramKey& key) const {
    if (folder_.empty()) {
        return {};
    }
    char name[64];
    std::snprintf(name,
                  sizeof(name),
                  "/%016llx.program",
                  static_cast<unsigned long long>(hash_of(head_of(key), 0)));
    return folder_ + name;
}

std::optional<Bytes> ProgramCache::load(const ProgramKey& key) const {
    if (folder_.empty()) {
        return std::nullopt;
    }
    const Bytes file = read_all(path_of(key));
    const Bytes head = head_of(key);
    // After the head: size of the binary, the binary, two sums over all before them.
    if (file.size() < head.size() + 24 || std::memcmp(file.data(), head.data(), head.size()) != 0) {
        return std::nullopt;
    }
    const std::span<const std::uint8_t> all(file);
    const std::uint64_t size = number_at(all.subspan(head.size()));
    if (size != file.size() - head.size() - 24) {
        return std::nullopt;
    }
    const auto summed = all.first(file.size() - 16);
    if (number_at(all.last(16)) != hash_of(summed, 1) ||
        number_at(all.last(8)) != hash_of(summed, 2)) {
        return std::nullopt;
    }
    const auto binary = all.subspan(head.size() + 8, size);
    return Bytes(binary.begin(), binary.end());
}

bool ProgramCache::store(const ProgramKey& key, std::span<const std::uint8_t> binary) const {
    if (folder_.empty()) {
        return false;
    }
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    Bytes file = head_of(key);
    put(file, binary.size());
    file.insert(file.end(), binary.begin(), binary.end());
    const std::uint64_t first = hash_of(file, 1);
    const std::uint64_t second = hash_of(file, 2);
    put(file, first);
    put(file, second);
    const std::string path = path_of(key);
    // Its own name for each writer: process numbers are not enough where containers share a folder.
    std::string fresh = path + ".XXXXXX";
    const int made = mkstemp(fresh.data());
    if (made < 0) {
        return false;
    }
    close(made);
    std::ofstream out(fresh, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(file.data()),
              static_cast<std::streamsize>(file.size()));
    out.close();  // a full disk shows its refusal only now
    if (out) {
        std::filesystem::rename(fresh, path, error);
    }
    if (!out || error) {
        std::error_code ignored;
        std::filesystem::remove(fresh, ignored);
        return false;
    }
    return true;
}

}  // namespace zoned::compute
