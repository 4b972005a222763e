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

    /// Lets the first call of a device fail, then the second of another, and so on until a device
    /// comes through. `work(device)` returns whether it did the work. Returns the number of faults.
    template <class Work>
    int fail_at_every_call(BufferMode mode, const Work& work) {
        for (int calls = 0;; ++calls) {
            DeviceFaults faults;
            faults.calls = calls;
            DeviceSettings settings;
            settings.testing = &faults;
            settings.buffers = mode;
            settings.cache_folder = ::testing::TempDir() + "zoned_programs_of_tests";
            const auto device = open(settings);
            if (device == nullptr || work(*device) || ::testing::Test::HasFailure()) {
                return calls;
            }
            EXPECT_TRUE(device->lost()) << "call " << calls;
        }
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
