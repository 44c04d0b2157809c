"""What a method is judged by: single steps, short pieces, memory, its ladder; and the verdict."""
