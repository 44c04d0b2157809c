"""What counts as asymptotic, clean and wrong: evidence is measured by it, and judged by it."""

#: Larger errors are not in the asymptotic range: on the unit sphere of directions they saturate.
ASYMPTOTIC = 0.1
#: Orders that differ by less than this are taken as equal.
ORDER_SLACK = 0.25
#: Safety factor of what rungs show that do not shrink as they should.
CAUTIOUS = 3.0
#: A limit is wrong if its distance from the exact motion is this many times its tolerance; between
#: one and this many times a finer rung has to decide.
DISTINCT = 4.0
#: At a rate Ω a method of order p makes an error of Ω (hΩ)^p a second. Where that exceeds one
#: within the time, the leading error term may be invisible, and no limit is called wrong.
WHOLE = 1.0
