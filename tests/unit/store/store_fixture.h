// Stores for tests: each kind that there is, in a folder of its own.
#pragma once

#include "server/store/sqlite_store.h"
#include "server/store/store.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

namespace zoned::store::test {

/// A folder that goes with its test.
class ScratchFolder {
  public:
    ScratchFolder() {
        static int made = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("zoned_store_" + std::to_string(::getpid()) + "_" + std::to_string(++made));
        std::filesystem::create_directories(path_);
    }

    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    [[nodiscard]] std::string file(const std::string& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
};

inline StoreKey world_key(const std::string& key) {
    return {StoreScope::kWorld, {}, {}, key};
}

inline StoreKey account_key(const std::string& account, const std::string& key) {
    return {StoreScope::kAccount, account, {}, key};
}

inline StoreKey character_key(const std::string& account,
                              const std::string& character,
                              const std::string& key) {
    return {StoreScope::kCharacter, account, character, key};
}

/// Takes the value of a result; a failed one fails the test.
template <class T>
T taken(StoreResult<T> result) {
    if (!result.ok()) {
        ADD_FAILURE() << result.error().text;
        return T();
    }
    return std::move(*result);
}

inline std::unique_ptr<Store> open_file(const std::string& file) {
    return taken(open_sqlite_store(file, Durability::kProcess));
}

}  // namespace zoned::store::test
