// SPDX-License-Identifier: BSD-3-Clause
#include "common/look_ahead.hpp"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

/// So many bytes, counting up, then the end or a failure.
class CountingSource final : public ByteSource {
 public:
  CountingSource(std::size_t size, bool fails) : size_(size), fails_(fails) {}
  Result<std::size_t> read(std::span<char> buffer) override {
    if (given_ == size_ && fails_) return invalid_input("damaged");
    const std::size_t count = std::min({buffer.size(), size_ - given_, std::size_t{1000}});
    for (std::size_t i = 0; i < count; ++i) buffer[i] = static_cast<char>(given_++ % 251);
    return count;
  }

 private:
  std::size_t size_;
  bool fails_;
  std::size_t given_ = 0;
};

LookAhead ahead_of(std::size_t size, bool fails = false) {
  return LookAhead(std::make_unique<CountingSource>(size, fails));
}

TEST(LookAhead, TellsWhatIsToCome) {
  LookAhead bytes = ahead_of(5000);
  EXPECT_EQ(bytes.available(10), 10u);
  EXPECT_EQ(bytes.available(1'000'000), 5000u);
  std::string taken(4990, ' ');
  EXPECT_EQ(bytes.take(taken.data(), taken.size()), 4990u);
  EXPECT_EQ(bytes.available(100), 10u);
  EXPECT_EQ(bytes.take(taken.data(), 100), 10u);
  EXPECT_EQ(bytes.available(1), 0u);
  EXPECT_FALSE(bytes.failure());
}

TEST(LookAhead, ReadsAgainFromTheMark) {
  LookAhead bytes = ahead_of(1'000'000);
  std::string piece(7001, ' ');
  std::size_t place = 0;
  for (int i = 0; i < 100; ++i) {
    bytes.set_mark();
    bytes.available(300'000);
    for (int again = 0; again < 2; ++again) {
      bytes.return_to_mark();
      ASSERT_EQ(bytes.take(piece.data(), piece.size()), piece.size());
      for (std::size_t j = 0; j < piece.size(); ++j) ASSERT_EQ(piece[j], static_cast<char>((place + j) % 251));
    }
    place += piece.size();
  }
}

TEST(LookAhead, AFailureComesBehindTheGoodBytes) {
  LookAhead bytes = ahead_of(3000, true);
  EXPECT_EQ(bytes.available(5000), 3000u);
  std::string taken(3000, ' ');
  EXPECT_EQ(bytes.take(taken.data(), taken.size()), 3000u);
  ASSERT_TRUE(bytes.failure());
  EXPECT_EQ(bytes.failure()->message, "damaged");
}

}  // namespace
}  // namespace slamfuse::common
