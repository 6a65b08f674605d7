// Random numbers that are the same on every platform: the standard's engines are, its distributions are not.
#pragma once

#include <cstdint>

namespace proximity {

// xoshiro256++, its state filled by splitmix64. Source: Blackman and Vigna, ACM Trans. Mathematical Software, 2021.
class Generator {
 public:
  explicit Generator(std::uint64_t seed) {
    for (auto& word : state_) {
      std::uint64_t mixed = (seed += 0x9e3779b97f4a7c15);
      mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9;
      mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111eb;
      word = mixed ^ (mixed >> 31);
    }
  }

  std::uint64_t next() {
    const std::uint64_t result = rotated(state_[0] + state_[3], 23) + state_[0], shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = rotated(state_[3], 45);
    return result;
  }

  // Evenly from 0 up to, not including, 1.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
  static std::uint64_t rotated(std::uint64_t word, int by) { return (word << by) | (word >> (64 - by)); }

  std::uint64_t state_[4];
};

}  // namespace proximity
