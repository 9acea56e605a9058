"""What the laws say, in fractions or 50 digits: truths that problems, sweeps and tests share."""
