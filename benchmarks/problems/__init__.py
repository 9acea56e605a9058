"""Questions with known answers, shared by benchmarks, tests and documents."""
