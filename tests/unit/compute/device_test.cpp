#include "server/compute/device.h"

#include "server/compute/host_block.h"
#include "server/compute/opencl_api.h"
#include "server/compute/stages/particle_stage.h"
#include "tests/unit/compute/device_fixture.h"

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

namespace zoned::compute {
namespace {

using DeviceLifeTest = DeviceTest;

bool is_mapped(const std::string& library) {
    std::ifstream maps("/proc/self/maps");
    const std::string all((std::istreambuf_iterator<char>(maps)), std::istreambuf_iterator<char>());
    return all.find(library) != std::string::npos;
}

ParticleScene falling() {
    ParticleScene scene;
    scene.world.h = 1.0F / 60.0F;
    scene.world.gy = -9.81F;
    return scene;
}

ParticleColumns standing(std::size_t count) {
    ParticleColumns columns;
    columns.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        columns.column(ParticleColumns::kX)[i] = 0.25F * static_cast<float>(i);
    }
    return columns;
}

bool all_fell_once(const ParticleColumns& columns, std::size_t count) {
    const float h = falling().world.h;
    const float speed = 0.0F + h * -9.81F;
    for (std::size_t i = 0; i < count; ++i) {
        if (columns.column(ParticleColumns::kVy)[i] != speed ||
            columns.column(ParticleColumns::kY)[i] != 0.0F + h * speed) {
            return false;
        }
    }
    return true;
}

/// The check of a scene without a device: exit code 0 where OpenCL stayed out of the process.
int work_without_a_device() {
    Team alone;
    ParticleStage stage;
    ParticleColumns columns = standing(1000);
    stage.step(columns, 1000, falling(), alone);
    DeviceSettings none;
    none.wish = "none";
    const bool refused = !Device::open(none).ok();
    const bool clean = !opencl_was_asked_for() && !is_mapped("OpenCL") && !is_mapped("pocl");
    return refused && clean && all_fell_once(columns, 1000) ? 0 : 1;
}

class OpenCl : public DeviceTest {
  protected:
    void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(OpenCl, IsNotLoadedBeforeADeviceIsNeeded) {
    EXPECT_EXIT(std::exit(work_without_a_device()), ::testing::ExitedWithCode(0), "");
}

TEST_F(OpenCl, IsLoadedByTheFirstDevice) {
    // The check above would find it.
    EXPECT_EXIT(
        {
            const bool before = is_mapped("libOpenCL");
            const auto device = Device::open({});
            std::_Exit(!before && is_mapped("libOpenCL") && is_mapped("pocl") ? 0 : 1);
        },
        ::testing::ExitedWithCode(0),
        "");
}

TEST_F(OpenCl, WithoutADriverGivesAReasonAndNoDevice) {
    const std::string folder = fresh_folder();
    std::filesystem::create_directories(folder);
    EXPECT_EXIT(
        {
            setenv("OCL_ICD_VENDORS", folder.c_str(), 1);
            const auto device = Device::open({});
            if (device.ok()) {
                std::_Exit(1);
            }
            std::fprintf(stderr, "%s\n", device.error().c_str());
            std::_Exit(0);
        },
        ::testing::ExitedWithCode(0),
        "no platform");
}

TEST_F(DeviceLifeTest, ListsAndChoosesAndSaysWhy) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    EXPECT_FALSE(device->info().name.empty());
    EXPECT_GE(device->info().compute_units, 1U);
    EXPECT_GT(device->info().memory_bytes, 0U);
    EXPECT_NE(device->reason().find(device->info().name), std::string::npos);
    DeviceSettings other;
    other.wish = "no such device";
    const auto none = Device::open(other);
    ASSERT_FALSE(none.ok());
    EXPECT_NE(none.error().find("no such device"), std::string::npos);
}

DeviceInfo made_up(const char* name, DeviceKind kind, unsigned units) {
    DeviceInfo info;
    info.name = name;
    info.kind = kind;
    info.compute_units = units;
    info.correctly_rounded = true;
    info.largest_group = 1024;
    return info;
}

TEST(ChooseDevice, TakesAGpuBeforeACpuAndTheLargerOfTwo) {
    DeviceInfo inexact = made_up("Fast", DeviceKind::kGpu, 99);
    inexact.correctly_rounded = false;
    const std::vector<DeviceInfo> list{made_up("Cpu", DeviceKind::kCpu, 64),
                                       made_up("Small", DeviceKind::kGpu, 8),
                                       made_up("Large", DeviceKind::kGpu, 16),
                                       inexact};
    EXPECT_EQ(choose_device(list, "").index, 2U);
    EXPECT_EQ(choose_device(list, "cpu").index, 0U);
    EXPECT_EQ(choose_device(list, "small").index, 1U);
    EXPECT_FALSE(choose_device(list, "none").index);
    const DeviceChoice refused = choose_device(list, "fast");
    EXPECT_FALSE(refused.index);
    EXPECT_NE(refused.reason.find("round"), std::string::npos);
    EXPECT_FALSE(choose_device({}, "auto").index);
}

TEST(ChooseGroup, KeepsToTheKernelsLimitAndTheDevicesWidth) {
    EXPECT_EQ(choose_group(made_up("", DeviceKind::kCpu, 2), 4096, 1), 1024U);
    EXPECT_EQ(choose_group(made_up("", DeviceKind::kGpu, 2), 1024, 32), 256U);
    EXPECT_EQ(choose_group(made_up("", DeviceKind::kGpu, 2), 128, 32), 128U);
    EXPECT_EQ(choose_group(made_up("", DeviceKind::kGpu, 2), 1024, 96), 192U);
    EXPECT_EQ(choose_group(made_up("", DeviceKind::kGpu, 2), 0, 0), 1U) << "a driver says nothing";
}

/// A file of kernels/ with a mistake, for the real compiler.
FindKernelFile broken(const std::string& path) {
    return [path](std::string_view wanted) -> std::optional<std::string_view> {
        if (wanted != path) {
            return std::nullopt;
        }
        return "// A mistake.\n__kernel void particles_step(__global float* x) {\n"
               "    x[0] = no_such_name;\n}\n";
    };
}

TEST_F(DeviceLifeTest, AKernelThatDoesNotBuildIsNamedWithFileAndLineAndTheCpuDoesTheWork) {
    DeviceSettings settings;
    settings.kernels = broken("kernels/particles.cl");
    const auto device = open(settings);
    ASSERT_NE(device, nullptr);
    ParticleStage stage(device.get());
    ParticleColumns columns = standing(3000);
    Team alone;
    const StageRun run = stage.step(columns, 3000, falling(), alone);
    EXPECT_FALSE(run.on_device);
    EXPECT_NE(run.fault.find("kernels/particles.cl:3"), std::string::npos) << run.fault;
    EXPECT_NE(run.fault.find("no_such_name"), std::string::npos) << run.fault;
    EXPECT_TRUE(all_fell_once(columns, 3000));
    EXPECT_FALSE(stage.has_device());
    EXPECT_TRUE(stage.step(columns, 3000, falling(), alone).fault.empty()) << "reported twice";
    EXPECT_FALSE(device->lost()) << "other kernels may go on";
}

TEST(KernelSource, NamesPlacesForCompilersThatCountTheWholeText) {
    const auto source = expand_kernel("a.cl", [](std::string_view path) {
        return path == "a.cl" ? std::optional<std::string_view>("1\n#include \"b.h\"\n3\n4\n")
                              : std::optional<std::string_view>("first of b\nsecond of b\n");
    });
    ASSERT_TRUE(source.ok());
    // Every line as a compiler would name it that counts from the top of the text.
    std::istringstream lines(*source);
    std::vector<std::string> found;
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        if (line[0] != '#') {
            found.push_back(
                name_places("<kernel>:" + std::to_string(number) + ":2: error", *source) + " " +
                line);
        }
    }
    EXPECT_EQ(found,
              (std::vector<std::string>{"a.cl:1:2: error 1",
                                        "b.h:1:2: error first of b",
                                        "b.h:2:2: error second of b",
                                        "a.cl:3:2: error 3",
                                        "a.cl:4:2: error 4"}));
    EXPECT_EQ(name_places("no place; <kernel>: none", *source), "no place; <kernel>: none");
}

TEST(KernelSource, NamesThePlaceOfAnIncludeThatIsNotThere) {
    const auto source = expand_kernel("a.cl", [](std::string_view path) {
        return path == "a.cl" ? std::optional<std::string_view>("\n#include \"b.h\"\n")
                              : std::nullopt;
    });
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.error(), "a.cl:2: there is no kernel file \"b.h\"");
}

TEST_F(DeviceLifeTest, ADeviceThatDiesHalfwayLosesNothing) {
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        for (const double share : {0.0, 0.4, 1.0}) {
            DeviceFaults faults;
            faults.launches = 0;
            faults.share_run = share;
            DeviceSettings settings;
            settings.testing = &faults;
            settings.buffers = mode;
            const auto device = open(settings);
            ASSERT_NE(device, nullptr);
            ParticleStage stage(device.get());
            constexpr std::size_t kMany = 10'003;
            ParticleColumns columns = standing(kMany);
            Team alone;
            const StageRun run = stage.step(columns, kMany, falling(), alone);
            EXPECT_FALSE(run.on_device);
            EXPECT_NE(run.fault.find("on purpose"), std::string::npos) << run.fault;
            EXPECT_TRUE(all_fell_once(columns, kMany)) << "share " << share;
            EXPECT_TRUE(device->lost());
            EXPECT_TRUE(stage.step(columns, kMany, falling(), alone).fault.empty());
        }
    }
}

/// Two steps, so that buffers are made in one and used again in the other.
TEST_F(DeviceLifeTest, WhicheverCallFailsTheStepIsDoneOnce) {
    constexpr std::size_t kMany = 5001;
    Team alone;
    ParticleColumns expected = standing(kMany);
    step_particles(expected, kMany, falling(), alone);
    step_particles(expected, kMany, falling(), alone);
    // A GPU never works on mapped columns: what a failed step leaves in them is its driver's
    // choice.
    for (const BufferMode mode : {BufferMode::kAuto, BufferMode::kCopied}) {
        const int faults = fail_at_every_call(mode, [&](Device& device) {
            ParticleStage stage(&device);
            ParticleColumns columns = standing(kMany);
            stage.step(columns, kMany, falling(), alone);
            const bool on_device = stage.step(columns, kMany, falling(), alone).on_device;
            for (std::size_t c = 0; c < ParticleColumns::kColumns; ++c) {
                EXPECT_EQ(std::memcmp(columns.column(c), expected.column(c), 4 * kMany), 0) << c;
            }
            return on_device;
        });
        EXPECT_GT(faults, 20) << "seven arguments, a launch and a wait, twice";
    }
}

/// In copied mode the fitting tables are being copied when the one that does not fit is refused.
/// This one is so large that its copy still runs when the stage releases it. A block of that size
/// goes back to the system at once, so that reading it ends the process.
TEST_F(DeviceLifeTest, AStageThatBrokeOffLeavesNoCopyOfItsMemoryBehind) {
    const std::size_t pages = 16'384;
    std::vector<float> gusts(pages * HostBlock::kPage / sizeof(float), 1.0F);
    ParticleScene scene = falling();
    scene.world.linear_drag = 0.1F;
    scene.gusts = gusts;
    // Pages: 25 of columns, one each of flags and world; those of the heights are too many.
    DeviceFaults faults;
    faults.memory_bytes = (27 + pages) * HostBlock::kPage;
    DeviceSettings settings;
    settings.testing = &faults;
    settings.buffers = BufferMode::kCopied;
    const auto device = open(settings);
    ASSERT_NE(device, nullptr);
    Team alone;
    {
        ParticleStage stage(device.get());
        ParticleColumns columns = standing(100);
        const StageRun run = stage.step(columns, 100, scene, alone);
        EXPECT_NE(run.fault.find("memory ran out"), std::string::npos) << run.fault;
    }
    EXPECT_FALSE(device->lost());
    EXPECT_TRUE(device->finish().ok());
    // Its memory is free again.
    ParticleStage other(device.get());
    ParticleColumns columns = standing(100);
    EXPECT_TRUE(other.step(columns, 100, falling(), alone).on_device);
}

TEST_F(DeviceLifeTest, ThreadsShareADeviceWhoseStagesComeAndGo) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    std::atomic<int> good{0};
    const auto work = [&](std::size_t count) {
        Team alone;
        for (int round = 0; round < 8; ++round) {
            ParticleStage stage(device.get());
            ParticleColumns columns = standing(count);
            const bool on_device = stage.step(columns, count, falling(), alone).on_device;
            good += on_device && all_fell_once(columns, count) ? 1 : 0;
        }
    };
    std::thread one(work, 3000);
    std::thread two(work, 9000);
    one.join();
    two.join();
    EXPECT_EQ(good, 16);
}

TEST_F(DeviceLifeTest, AKernelThatDoesNotBuildIsNotBuiltAgain) {
    int asked = 0;
    DeviceSettings settings;
    settings.kernels = [&asked](std::string_view) -> std::optional<std::string_view> {
        ++asked;
        return "no kernel at all\n";
    };
    const auto device = open(settings);
    ASSERT_NE(device, nullptr);
    Team alone;
    for (int stages = 0; stages < 3; ++stages) {
        ParticleStage stage(device.get());
        ParticleColumns columns = standing(10);
        EXPECT_FALSE(stage.step(columns, 10, falling(), alone).fault.empty());
    }
    EXPECT_EQ(asked, 1);
}

TEST_F(DeviceLifeTest, ADeviceWithoutMemoryLeavesTheWorkToTheCpu) {
    DeviceFaults faults;
    faults.memory_bytes = 1U << 16U;
    DeviceSettings settings;
    settings.testing = &faults;
    const auto device = open(settings);
    ASSERT_NE(device, nullptr);
    ParticleStage stage(device.get());
    ParticleColumns columns = standing(50'000);
    Team alone;
    const StageRun run = stage.step(columns, 50'000, falling(), alone);
    EXPECT_NE(run.fault.find("memory ran out"), std::string::npos) << run.fault;
    EXPECT_TRUE(all_fell_once(columns, 50'000));
}

TEST_F(DeviceLifeTest, ABufferLargerThanTheDeviceIsRefused) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    HostBlock small(HostBlock::kPage);
    const auto buffer =
        Buffer::over(*device, small.data(), device->info().largest_buffer_bytes + 1);
    ASSERT_FALSE(buffer.ok());
    EXPECT_NE(buffer.error().find("at most"), std::string::npos) << buffer.error();
    EXPECT_FALSE(device->lost());
}

TEST_F(DeviceLifeTest, CopiedBuffersGiveTheSameAsMappedOnes) {
    for (const BufferMode mode : {BufferMode::kMapped, BufferMode::kCopied}) {
        DeviceSettings settings;
        settings.buffers = mode;
        const auto device = open(settings);
        ASSERT_NE(device, nullptr);
        ParticleStage stage(device.get());
        ParticleColumns columns = standing(5001);
        Team alone;
        const StageRun run = stage.step(columns, 5001, falling(), alone);
        EXPECT_TRUE(run.on_device) << run.fault;
        EXPECT_TRUE(all_fell_once(columns, 5001));
    }
}

/// The programs of a device that has built one kernel with this cache.
ProgramCounts build_once(const std::string& folder, const DeviceFaults* faults = nullptr) {
    DeviceSettings settings;
    settings.cache_folder = folder;
    settings.testing = faults;
    const auto device = Device::open(settings);
    EXPECT_TRUE(device.ok());
    ParticleStage stage(device->get());
    ParticleColumns columns = standing(2000);
    Team alone;
    const StageRun run = stage.step(columns, 2000, falling(), alone);
    EXPECT_TRUE(run.on_device) << run.fault;
    EXPECT_TRUE(all_fell_once(columns, 2000));
    return (*device)->programs();
}

std::filesystem::path only_file(const std::string& folder) {
    return std::filesystem::directory_iterator(folder)->path();
}

TEST_F(DeviceLifeTest, TheProgramCacheSurvivesARestart) {
    const std::string folder = fresh_folder();
    const ProgramCounts first = build_once(folder);
    EXPECT_EQ(first.built, 1U);
    EXPECT_EQ(first.stored, 1U);
    const ProgramCounts second = build_once(folder);
    EXPECT_EQ(second.built, 0U);
    EXPECT_EQ(second.loaded, 1U);
}

TEST_F(DeviceLifeTest, ADamagedCacheIsBuiltAnewAndNeverTrusted) {
    const std::string folder = fresh_folder();
    build_once(folder);
    const auto size = std::filesystem::file_size(only_file(folder));
    for (const std::uintmax_t at : {std::uintmax_t{3}, size / 2, size - 3}) {
        {
            std::fstream file(only_file(folder), std::ios::in | std::ios::out | std::ios::binary);
            file.seekg(static_cast<std::streamoff>(at));
            const char was = static_cast<char>(file.get());
            file.seekp(static_cast<std::streamoff>(at));
            file.put(static_cast<char>(was ^ 0x10));
        }
        EXPECT_EQ(build_once(folder).built, 1U) << "byte " << at;
        EXPECT_EQ(build_once(folder).loaded, 1U) << "it was not written anew";
    }
    std::filesystem::resize_file(only_file(folder), size / 3);
    EXPECT_EQ(build_once(folder).built, 1U);
}

TEST_F(DeviceLifeTest, ACacheFolderFullOfOtherThingsDoesNoHarm) {
    const std::string folder = fresh_folder();
    build_once(folder);
    const std::filesystem::path program = only_file(folder);
    // A folder where the program ought to be, with something in it.
    std::filesystem::remove(program);
    std::filesystem::create_directories(program / "inside");
    for (int start = 0; start < 2; ++start) {
        const ProgramCounts counts = build_once(folder);
        EXPECT_EQ(counts.built, 1U);
        EXPECT_EQ(counts.stored, 0U) << "there is no place for it";
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1)
            << "what could not be put in place was left behind";
    }
    // An empty file, then one of the right name that is another's.
    std::filesystem::remove_all(program);
    std::ofstream(program).close();
    EXPECT_EQ(build_once(folder).built, 1U);
    std::ofstream(program) << "garbage\n";
    EXPECT_EQ(build_once(folder).built, 1U);
    EXPECT_EQ(build_once(folder).loaded, 1U);
}

TEST_F(DeviceLifeTest, ACacheFolderThatIsAFileKeepsNothing) {
    const std::string folder = fresh_folder();
    std::ofstream(folder) << "a file";
    const ProgramCounts counts = build_once(folder);
    EXPECT_EQ(counts.built, 1U);
    EXPECT_EQ(counts.stored, 0U);
}

TEST_F(DeviceLifeTest, AGroupThatNoColumnsFitLeavesTheWorkToTheCpu) {
    const auto device = open();
    ASSERT_NE(device, nullptr);
    Team alone;
    // Small enough that no device cuts them to what its kernel can have.
    for (const std::size_t group : {std::size_t{1}, std::size_t{24}, std::size_t{40}}) {
        ParticleStage stage(device.get(), {group, false});
        ParticleColumns columns = standing(2000);
        const StageRun run = stage.step(columns, 2000, falling(), alone);
        EXPECT_NE(run.fault.find("work groups of"), std::string::npos) << run.fault;
        EXPECT_TRUE(all_fell_once(columns, 2000));
    }
    ParticleStage cut(device.get(), {SIZE_MAX, false});
    ParticleColumns columns = standing(2000);
    const StageRun run = cut.step(columns, 2000, falling(), alone);
    EXPECT_TRUE(run.on_device) << "cut to the kernel's limit: " << run.fault;
    EXPECT_TRUE(all_fell_once(columns, 2000));
}

TEST_F(DeviceLifeTest, ABinaryThatTheDriverRefusesIsBuiltAnew) {
    const std::string folder = fresh_folder();
    build_once(folder);
    DeviceFaults faults;
    faults.refuse_binaries = true;
    EXPECT_EQ(build_once(folder, &faults).built, 1U);
}

TEST(ProgramCache, ReadersSeeAllOfAFileOrNoneWhileOthersWriteIt) {
    const auto folder = std::filesystem::path(::testing::TempDir()) / "zoned_program_writers";
    std::filesystem::remove_all(folder);
    const ProgramCache cache(folder.string());
    const ProgramKey key{"device", "driver 1", "-DA", "source"};
    const std::vector<std::uint8_t> binary(200'000, 7);
    ASSERT_TRUE(cache.store(key, binary));
    std::atomic<int> stored{0};
    const auto write = [&] {
        for (int i = 0; i < 50; ++i) {
            stored += cache.store(key, binary) ? 1 : 0;
        }
    };
    std::thread one(write);
    std::thread two(write);
    int torn = 0;
    while (stored < 100) {
        torn += cache.load(key) == binary ? 0 : 1;
        std::this_thread::yield();
        if (torn > 0) {
            break;
        }
    }
    one.join();
    two.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(stored, 100);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST(ProgramCache, KeepsProgramsOfOtherKeysApart) {
    const auto folder = std::filesystem::path(::testing::TempDir()) / "zoned_program_keys";
    std::filesystem::remove_all(folder);
    const ProgramCache cache(folder.string());
    const ProgramKey key{"device", "driver 1", "-DA", "source"};
    const std::vector<std::uint8_t> binary{1, 2, 3};
    ASSERT_TRUE(cache.store(key, binary));
    EXPECT_EQ(cache.load(key), binary);
    ProgramKey other = key;
    other.driver = "driver 2";
    EXPECT_FALSE(cache.load(other));
    // Not even where another key's file lies in its place.
    std::filesystem::copy_file(cache.path_of(key), cache.path_of(other));
    EXPECT_FALSE(cache.load(other));
}

}  // namespace
}  // namespace zoned::compute
