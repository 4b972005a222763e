// DeviceTest: an OpenCL device for tests, PoCL's where there is no other.
#pragma once

#include "server/compute/device.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

namespace zoned::compute {

/// CI installs PoCL: a machine without any device fails these tests rather than skipping them.
class DeviceTest : public ::testing::Test {
  protected:
    std::unique_ptr<Device> open(DeviceSettings settings = {}) {
        auto opened = Device::open(settings);
        if (!opened) {
            ADD_FAILURE() << opened.error();
            return nullptr;
        }
        return std::move(*opened);
    }

    /// An empty folder of this test's own.
    static std::string fresh_folder() {
        const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
        const std::filesystem::path folder =
            std::filesystem::path(::testing::TempDir()) /
            (std::string("zoned_") + test->test_suite_name() + "_" + test->name());
        std::filesystem::remove_all(folder);
        return folder.string();
    }
};

}  // namespace zoned::compute
